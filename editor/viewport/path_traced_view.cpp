#include "editor/viewport/path_traced_view.h"

#include <algorithm>
#include <limits>

#include "base/text.h"
#include "passes/overlay.h"
#include "passes/scene_bindings.h"

namespace raygraph::viewport {

namespace {

using passes::Accumulation;
using passes::Region;
using passes::TileCursor;

constexpr uint32_t kMaxLevels = 10;
constexpr uint64_t kPreviewPixels = uint64_t{1} << 18;  // 0.1 s on two cores

uint64_t PixelsOf(Extent2D extent) {
    return uint64_t{extent.width} * extent.height;
}

bool Fits(Extent2D extent, const FrameBudget& budget) {
    return budget.PixelsWithin(extent, {}, budget.TracingMs()) >= PixelsOf(extent);
}

}  // namespace

PathTracedView::PathTracedView(const std::string& name) : m_full(name + ".path-traced") {
    for (uint32_t i = 1; i <= kMaxLevels; ++i)
        m_levels.push_back(
            {.scale = 1u << i, .sample = Accumulation(Text("{}.path-traced/{}", name, 1u << i))});
}

Extent2D PathTracedView::ExtentAt(Extent2D extent, uint32_t scale) {
    return {(extent.width + scale - 1) / scale, (extent.height + scale - 1) / scale};
}

PathTracedView::FrameLimits PathTracedView::LimitsOf(Extent2D extent, const FrameBudget& budget,
                                                     const BudgetSettings& settings, bool isChanging) {
    constexpr uint32_t kMostSamples = 64, kUnlimited = std::numeric_limits<uint32_t>::max();
    FrameLimits limits{.mostSamples = settings.samplesPerFrame,
                       .endSample = settings.maxSamples > 0 ? settings.maxSamples : kUnlimited,
                       .coarsest = kUnlimited};
    if (limits.mostSamples == 0) limits.mostSamples = budget.IsLimited() && !isChanging ? kMostSamples : 1;
    // The first picture after a movement may take a few frames' time, if it is known that it takes no longer
    constexpr double kMostFrames = 4.0;
    if (settings.whileMoving == MotionView::Auto && !isChanging && budget.HasTimings() &&
        !Exceeds(extent, kCoarsestMotion, budget, kMostFrames * budget.Limit()))
        limits.coarsest = kCoarsestMotion;
    return limits;
}

bool PathTracedView::Exceeds(Extent2D extent, uint32_t scale, const FrameBudget& budget,
                             double milliseconds) {
    const Extent2D coarse = ExtentAt(extent, scale);
    return budget.IsLimited() && budget.HasTimings() &&
           budget.Expect(coarse.height, passes::WholeOf(coarse)) > milliseconds;
}

size_t PathTracedView::LevelCount(Extent2D extent, uint32_t coarsest) const {
    size_t count = 0;
    uint64_t pixels = PixelsOf(extent);
    while (pixels > FrameBudget::kFirstPixels && count < m_levels.size() && m_levels[count].scale <= coarsest)
        pixels = PixelsOf(ExtentAt(extent, m_levels[count++].scale));
    return count;
}

void PathTracedView::Reset(passes::ResetCause cause) {
    m_full.Reset(cause);
    for (Level& level : m_levels) level.sample.Reset(cause);
}

void PathTracedView::Release(Renderer& renderer) {
    passes::Release(renderer, m_full);
    for (const Level& level : m_levels) passes::Release(renderer, level.sample);
}

uint32_t PathTracedView::Coarseness() const {
    if (m_full.SampleCount() > 0) return 1;
    for (const Level& level : m_levels)
        if (level.sample.SampleCount() > 0) return level.scale;
    return 0;
}

std::vector<Region> PathTracedView::TilesOfSamples() const {
    std::vector<Region> regions;
    for (const Tile& tile : m_tiles)
        if (tile.isOfSample) regions.push_back(tile.region);
    return regions;
}

passes::AccumulatedIds PathTracedView::DeclareTile(Renderer& renderer, const SceneIds& scene,
                                                   passes::TraceSettings settings, const Region& region,
                                                   uint32_t sampleCount, Accumulation& into,
                                                   bool withVariance) {
    settings.sampleIndex = into.Declared().sampleCount;
    settings.sampleCount = sampleCount;
    settings.region = region;
    const PassId first = renderer.NextPass();
    const TextureId traced = passes::Trace(renderer, scene, settings).radiance;
    m_tiles.push_back({.height = settings.extent.height,
                       .region = region,
                       .isOfSample = &into == &m_full,
                       .sampleCount = sampleCount,
                       .first = first,
                       .end = renderer.NextPass()});
    if (sampleCount > 1)
        return passes::Accumulate(renderer, traced, {.count = sampleCount}, into, withVariance);
    return passes::AccumulateTile(renderer, traced, settings.extent, region, into, withVariance);
}

PathTracedView::Level* PathTracedView::Finest() {
    for (Level& level : m_levels)
        if (level.sample.SampleCount() > 0) return &level;
    return nullptr;
}

PathTracedView::Level* PathTracedView::FinerThan(const Level& level) {
    for (Level& finer : m_levels)
        if (2 * finer.scale == level.scale) return &finer;
    return nullptr;
}

PathTracedView::Level* PathTracedView::FirstToTrace(Extent2D extent, const FrameBudget& budget,
                                                    uint32_t coarsest) {
    if (Fits(extent, budget)) return nullptr;
    const size_t count = LevelCount(extent, coarsest);
    for (size_t i = 0; i < count; ++i)
        if (Fits(ExtentAt(extent, m_levels[i].scale), budget) || i + 1 == count) return &m_levels[i];
    return nullptr;
}

PathTracedView::Ids PathTracedView::Declare(Renderer& renderer, const SceneIds& scene,
                                            passes::TraceSettings settings, const FrameBudget& budget,
                                            const BudgetSettings& budgetSettings, bool isChanging,
                                            const PreviewSettings& preview) {
    m_tiles.clear();
    const FrameLimits limits = LimitsOf(settings.extent, budget, budgetSettings, isChanging);
    if (preview.isOn) {
        const TracePrograms::Choice program =
            m_programs.Choose(renderer, scene, settings, m_full.SampleCount(), m_isPreviewReady);
        if (!program.isReady) return DeclarePreview(renderer, scene, settings, preview);
        m_isPreviewReady = false;  // this scene's preview may need other pipelines
        if (program.more != TraceFeatures{}) {
            const SceneIds wide = passes::WithFeatures(scene, program.more);
            return DeclareTraced(renderer, wide, settings, budget, limits);
        }
    }
    m_programs.MarkUsed();
    return DeclareTraced(renderer, scene, settings, budget, limits);
}

passes::AccumulatedIds PathTracedView::DeclareSamples(Renderer& renderer, const SceneIds& scene,
                                                      const passes::TraceSettings& settings,
                                                      const FrameBudget& budget,
                                                      const BudgetSettings& budgetSettings) {
    m_tiles.clear();
    m_programs.MarkUsed();
    const FrameLimits limits = LimitsOf(settings.extent, budget, budgetSettings, false);
    return DeclareSamples(renderer, scene, settings, budget, limits).samples;
}

PathTracedView::Ids PathTracedView::DeclareTraced(Renderer& renderer, const SceneIds& scene,
                                                  const passes::TraceSettings& settings,
                                                  const FrameBudget& budget, const FrameLimits& limits) {
    const bool isBegun = !m_full.Declared().cursor.IsAtStart();
    if (m_full.SampleCount() == 0 && (budget.IsLimited() || isBegun))
        return DeclareFirstSample(renderer, scene, settings, budget, limits.coarsest);
    return DeclareSamples(renderer, scene, settings, budget, limits);
}

PathTracedView::Ids PathTracedView::DeclareSamples(Renderer& renderer, const SceneIds& scene,
                                                   const passes::TraceSettings& settings,
                                                   const FrameBudget& budget, const FrameLimits& limits) {
    passes::AccumulatedIds ids = passes::StoredAccumulation(renderer, m_full, settings.extent, true);
    const uint32_t atOnce = passes::PreferredBatchSize(renderer.Device(), settings);
    double left = budget.TracingMs();
    for (uint32_t taken = 0; taken < limits.mostSamples;) {
        const Accumulation::Progress& progress = m_full.Declared();
        if (progress.sampleCount >= limits.endSample) break;
        const Region region = progress.cursor.Next(
            settings.extent, budget.PixelsWithin(settings.extent, progress.cursor, left));
        const double expected = budget.Expect(settings.extent.height, region);
        // A frame traces at least the tile that was begun, and more only where it fits
        if (taken > 0 && budget.IsLimited() && expected > left) break;
        uint32_t count = 1;
        if (region == passes::WholeOf(settings.extent)) {
            count = std::min({atOnce, limits.mostSamples - taken, limits.endSample - progress.sampleCount});
            if (budget.IsLimited())
                count =
                    budget.HasTimings() && expected > 0.0
                        ? static_cast<uint32_t>(std::clamp(left / expected, 1.0, static_cast<double>(count)))
                        : 1;
        }
        left -= count * expected;
        taken += count;
        ids = DeclareTile(renderer, scene, settings, region, count, m_full, true);
        if (!m_full.Declared().cursor.IsAtStart()) break;
    }
    return {.radiance = ids.mean, .samples = ids, .base = ids.mean};
}

PathTracedView::Ids PathTracedView::DeclarePreview(Renderer& renderer, const SceneIds& scene,
                                                   const passes::TraceSettings& settings,
                                                   const PreviewSettings& preview) {
    const Extent2D extent = settings.extent;
    Ids ids{.samples = passes::StoredAccumulation(renderer, m_full, extent, true), .isPreview = true};
    passes::TraceSettings coarse = settings;
    while (PixelsOf(coarse.extent) > kPreviewPixels) coarse.extent = ExtentAt(extent, ids.baseScale *= 2);
    const PassId first = renderer.NextPass();
    ids.radiance = ids.base = passes::Preview(renderer, scene, coarse, preview.gain);
    // If there are samples, nothing has changed since they were shown: the picture is valid
    m_isPreviewReady = renderer.PreparePipelines(first, renderer.NextPass());
    ids.isHeld = preview.canHold && (!m_isPreviewReady || m_full.SampleCount() > 0);
    if (ids.baseScale > 1) ids.radiance = passes::Upscale(renderer, ids.base, extent);
    return ids;
}

PathTracedView::Ids PathTracedView::DeclareFirstSample(Renderer& renderer, const SceneIds& scene,
                                                       const passes::TraceSettings& settings,
                                                       const FrameBudget& budget, uint32_t coarsest) {
    const Extent2D extent = settings.extent;
    Level* const shown = Finest();
    Level* const next = shown == nullptr ? FirstToTrace(extent, budget, coarsest) : FinerThan(*shown);
    Accumulation& into = next != nullptr ? next->sample : m_full;
    passes::TraceSettings coarse = settings;
    if (next != nullptr) coarse.extent = ExtentAt(extent, next->scale);
    const TileCursor cursor = into.Declared().cursor;
    // The first picture is traced as a whole: nothing could be shown in place of missing tiles
    const Region region =
        shown == nullptr
            ? passes::WholeOf(coarse.extent)
            : cursor.Next(coarse.extent, budget.PixelsWithin(coarse.extent, cursor, budget.TracingMs()));
    const passes::AccumulatedIds traced =
        DeclareTile(renderer, scene, coarse, region, 1, into, next == nullptr);

    Ids ids{.radiance = traced.mean,
            .samples = traced,
            .base = traced.mean,
            .baseScale = next != nullptr ? next->scale : 1};
    if (into.Declared().sampleCount == 0) {
        ids.base =
            passes::StoredAccumulation(renderer, shown->sample, ExtentAt(extent, shown->scale), false).mean;
        ids.baseScale = shown->scale;
        ids.radiance = passes::Overlay(renderer, ids.base, traced.mean, into.Declared().cursor);
    }
    if (next != nullptr && into.Declared().sampleCount == 0) {
        ids.finer = traced.mean;
        ids.finerTile = region;
    }
    if (next != nullptr) {
        ids.radiance = passes::Upscale(renderer, ids.radiance, extent);
        ids.samples = passes::StoredAccumulation(renderer, m_full, extent, true);
    }
    return ids;
}

// --- TracePrograms ---

namespace {

// Holds the passes of the program with those additional features, declared in the open frame and culled.
// Others that settings choose are compiled in as well, so only the renderer can say whether a program exists.
class DeclaredProgram {
  public:
    DeclaredProgram(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                    TraceFeatures more)
        : m_renderer(renderer), m_first(renderer.NextPass()) {
        static_cast<void>(passes::Trace(renderer, passes::WithFeatures(scene, more), settings));
        m_end = renderer.NextPass();
    }
    bool IsReady() const { return m_renderer.HasPipelines(m_first, m_end); }
    bool Prepare() const { return m_renderer.PreparePipelines(m_first, m_end); }

  private:
    Renderer& m_renderer;
    PassId m_first, m_end;
};

}  // namespace

TracePrograms::Choice TracePrograms::Choose(Renderer& renderer, const SceneIds& scene,
                                            const passes::TraceSettings& settings, uint32_t samples,
                                            bool mayMake) {
    if (!mayMake && !m_isUsed) return {};
    const TraceFeatures wanted = passes::ProgramFeatures(scene, settings);
    const TraceFeatures more = m_features & ~wanted;
    const DeclaredProgram own(renderer, scene, settings, {});
    if (!own.IsReady()) {
        const bool supportsAll = more != TraceFeatures{} && (wanted & ~m_features) == TraceFeatures{};
        const bool isFallbackReady =
            supportsAll && DeclaredProgram(renderer, scene, settings, more).IsReady();
        const bool makes = isFallbackReady ? samples >= kSettledSamples : mayMake;
        // A failure counts only where no other program exists
        const bool isReady = makes && own.Prepare() && (own.IsReady() || !isFallbackReady);
        if (!isReady) return {isFallbackReady, isFallbackReady ? more : TraceFeatures{}};
    }
    m_features = wanted;
    m_isUsed = true;
    return {true, {}};
}

}  // namespace raygraph::viewport
