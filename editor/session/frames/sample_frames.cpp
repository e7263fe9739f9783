#include "editor/session/frames/sample_frames.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "editor/session/settings/error_goal.h"
#include "passes/project_hits.h"
#include "passes/raster.h"
#include "passes/scene_bindings.h"
#include "renderer/graph/readback_values.h"
#include "rhi/device.h"
#include "shaders/shared/mix_bits.h"

namespace raygraph::session {

namespace {

// Returns the persistent texture of the pixels' hits, from one frame to the next.
TextureId MotionHits(Renderer& renderer, const passes::TraceSettings& settings) {
    return renderer.Persist("motion hits", {passes::RegionOf(settings).Extent(), Format::Rgba32Uint});
}

// The motion is 0 for a surface that is behind the camera at one of the times.
std::vector<float> MotionOf(const Texels& open, const Texels& close) {
    std::vector<float> motion(open.size() / 2, 0.0f);
    for (size_t i = 0; i < open.size() / 4; ++i) {
        if (open[4 * i + 2] != 0.0f || close[4 * i + 2] != 0.0f) continue;
        for (size_t c = 0; c < 2; ++c) motion[2 * i + c] = close[4 * i + c] - open[4 * i + c];
    }
    return motion;
}

}  // namespace

SampleFrames::SampleFrames(DeviceScene& scene, const FramePlan& plan)
    : m_scene(scene),
      m_renderer(scene.GraphRenderer()),
      m_plan(plan),
      m_secondTraces(plan.retraced),
      m_isKeepingAlbedo(plan.aovs.Has(Aov::Albedo) || (plan.NeedsGuides() && scene.IsBlurred())),
      m_isKeepingNormal(plan.aovs.Has(Aov::Normal) || (plan.NeedsGuides() && scene.IsBlurred())),
      m_isKeepingCenter(plan.hasUnblurred && plan.aovs.NeedsCenterRay()),
      m_isKeepingMotion(plan.hasUnblurred && plan.aovs.Has(Aov::Motion)) {
    for (size_t i = 0; i < passes::kPathPartCount; ++i)
        if (const Aov aov = AovOf(static_cast<passes::PathPart>(i)); plan.aovs.Has(aov))
            m_parts.push_back({i, Accumulated(Name(aov))});
    m_batchSize = ChooseBatchSize();
    if (plan.isAdaptive && plan.continues == nullptr)
        m_adaptive = std::make_unique<AdaptiveFrames>(m_renderer, Size(), plan.firstSample);
    if (plan.continues != nullptr) RestoreFrom(*plan.continues);
    m_plan.continues = nullptr;
}

void SampleFrames::RestoreFrom(const RenderFile& render) {
    const Extent2D extent{render.size.width, render.size.height};
    const uint32_t count = render.samples.front().count;
    const RenderSums& sums = render.sums;
    m_renderer.BeginFrame();
    passes::Restore(m_renderer, m_radiance.accumulation, extent, count, sums.radiance);
    const bool hasAverages =
        !(m_isKeepingAlbedo && sums.albedo.IsEmpty()) && !(m_isKeepingNormal && sums.normal.IsEmpty());
    uint32_t averaged = count;
    if (render.adaptive) {
        m_adaptive =
            std::make_unique<AdaptiveFrames>(m_renderer, extent, m_plan.firstSample, *render.adaptive);
        averaged = m_uniformSamples = m_adaptive->Counts().MinimumCount();
    }
    if (m_isKeepingAlbedo && hasAverages)
        passes::Restore(m_renderer, m_albedo.accumulation, extent, averaged, sums.albedo);
    if (m_isKeepingNormal && hasAverages)
        passes::Restore(m_renderer, m_normal.accumulation, extent, averaged, sums.normal);
    for (KeptPart& part : m_parts)
        passes::Restore(m_renderer, part.sum.accumulation, extent, count, sums.parts[part.index]);
    if (m_plan.lightGroupCount > 0) {
        const Extent2D tiles = passes::LightGroupTiles(m_plan.lightGroupCount);
        passes::Restore(m_renderer, m_groups.accumulation,
                        {tiles.width * extent.width, tiles.height * extent.height}, count,
                        TilesFromGroups(sums.lightGroups, render.size));
    }
    m_secondTraces.Restore(m_renderer, render);
    m_renderer.Execute();
    m_submitted = count;
    m_samples = render.samples;
    m_lastRestored = static_cast<uint32_t>(m_samples.back().End() - 1);
    if (!hasAverages) m_toRestore = count;
}

void SampleFrames::RestoreSample() {
    RG_CHECK(m_toRestore > 0);
    const uint32_t sample = m_lastRestored + 1 - m_toRestore;
    m_renderer.BeginFrame();
    const SceneIds ids = m_scene.Declare(sample);
    DeclareAverages(ids, m_scene.SettingsFor(sample));
    m_renderer.Execute();
    --m_toRestore;
}

Extent2D SampleFrames::Size() const {
    return passes::RegionOf(m_scene.SettingsFor(0)).Extent();
}

uint32_t SampleFrames::ChooseBatchSize() const {
    const passes::TraceSettings settings = m_scene.SettingsFor(0);
    // These differ between samples: the time, second traces, the length of all paths
    if (!TracesPaths() || m_scene.IsBlurred() || m_secondTraces.HasAny() ||
        settings.roulette.kind == Roulette::Frame)
        return 1;
    if (m_plan.batchSize > 0) return m_plan.batchSize;
    const bool hasGroups = m_plan.lightGroupCount > 0;
    const uint32_t most =
        passes::PreferredBatchSize(m_renderer.Device(), settings,
                                   hasGroups ? passes::LightGroupTiles(m_plan.lightGroupCount).height : 1);
    // For the denoiser, frames end where half of few samples does
    if (m_plan.NeedsGuides()) return std::min(most, 8u);
    // Albedo and normal have passes for each sample
    return m_isKeepingAlbedo || m_isKeepingNormal ? std::min(most, 16u) : most;
}

void SampleFrames::AccumulateFrame(TextureId samples, uint32_t count, Accumulated& into, bool isLast) {
    const passes::SampleRows rows{.count = count, .height = Size().height};
    const passes::AccumulatedIds ids = passes::Accumulate(m_renderer, samples, rows, into.accumulation);
    if (isLast) m_renderer.Present(ids.sums[0]);
}

void SampleFrames::AccumulateTraced(TextureId samples, const passes::TraceSettings& settings,
                                    passes::Accumulation& accumulation, bool withVariance) {
    const uint32_t count = settings.sampleCount;
    const passes::AccumulatedIds ids =
        settings.pixels.HasPixels()
            ? passes::AccumulateListed(m_renderer, samples, count, settings.pixels, Size(), accumulation,
                                       withVariance)
            : passes::Accumulate(m_renderer, samples, {.count = count, .height = Size().height}, accumulation,
                                 withVariance);
    m_renderer.Present(ids.sums[0]);
}

passes::TraceIds SampleFrames::DeclareSamples(const SceneIds& ids, const passes::TraceSettings& settings) {
    if (TracesPaths())
        return passes::Trace(m_renderer, ids, settings,
                             {.parts = !m_parts.empty(), .lightGroups = m_plan.lightGroupCount > 0});
    return {.radiance = passes::AnyRasterShade(m_renderer, ids, settings, passes::FilmPosition::Jittered,
                                               m_filteredEnvironment, m_plan.raster)};
}

void SampleFrames::DeclareRadiance(const SceneIds& ids, const passes::TraceSettings& settings) {
    const passes::TraceIds sample = DeclareSamples(ids, settings);
    if (TracesPaths()) m_counts.push_back({m_renderer.ReadBack(sample.counts), passes::PathCount(settings)});
    for (KeptPart& part : m_parts)
        AccumulateTraced(sample.parts[part.index], settings, part.sum.accumulation);
    if (m_plan.lightGroupCount > 0) AccumulateTraced(sample.lightGroups, settings, m_groups.accumulation);
    if (!m_adaptive)
        m_secondTraces.Declare(m_renderer, settings, sample.radiance,
                               [&](const auto& others) { return DeclareSamples(ids, others).radiance; });
    AccumulateTraced(sample.radiance, settings, m_radiance.accumulation, m_plan.withVariance);
}

void SampleFrames::DeclareValues(const SceneIds& ids, const passes::TraceSettings& settings) {
    const passes::FilmPosition film =
        passes::IsAverageable(m_plan.view) ? passes::FilmPosition::Jittered : passes::FilmPosition::Center;
    AccumulateFrame(
        passes::ViewValues(m_renderer, ids, settings, m_plan.view, film, passes::SurfaceSource::Rays), 1,
        m_radiance);
}

void SampleFrames::DeclareAverages(const SceneIds& ids, const passes::TraceSettings& settings, bool isLast) {
    const passes::PrimaryHitIds hits =
        passes::PrimaryHits(m_renderer, ids, settings, passes::FilmPosition::Jittered);
    if (m_isKeepingAlbedo) AccumulateFrame(hits.albedo, 1, m_albedo, isLast);
    if (m_isKeepingNormal) AccumulateFrame(hits.normal, 1, m_normal, isLast);
}

// Decisions at random, as whether a partly transparent surface is visible, are those of the picture's first
// sample, whichever device renders it and however often the picture is finished.
void SampleFrames::TraceUnblurred() {
    m_renderer.BeginFrame();
    const SceneIds ids = m_scene.DeclareUnblurred();
    const passes::TraceSettings settings = m_scene.SettingsFor(m_plan.firstSample);
    if (m_isKeepingCenter) {
        const passes::PrimaryHitIds hits =
            passes::PrimaryHits(m_renderer, ids, settings, passes::FilmPosition::Center);
        m_position = m_renderer.ReadBack(hits.position);
        m_ids = m_renderer.ReadBack(hits.ids);
    }
    if (m_isKeepingMotion)
        m_renderer.Present(passes::TraceHits(m_renderer, ids, settings, MotionHits(m_renderer, settings)));
    m_renderer.Execute();
    m_wasSharpTraced = true;
    if (!m_isKeepingMotion) return;
    m_placesAtOpen = ProjectAt(0.0, settings.camera);
    m_placesAtClose = ProjectAt(1.0, settings.camera);
}

Readback SampleFrames::ProjectAt(double shutterPosition, const gpu::CameraRecord& seenBy) {
    m_renderer.BeginFrame();
    const SceneIds ids = m_scene.DeclareInShutter(shutterPosition);
    const passes::TraceSettings settings = m_scene.SettingsFor(m_plan.firstSample);
    const Readback places = m_renderer.ReadBack(
        passes::ProjectHits(m_renderer, ids, settings, MotionHits(m_renderer, settings), seenBy));
    m_renderer.Execute();
    return places;
}

void SampleFrames::RenderSamples(SampleRange samples) {
    RG_CHECK(samples.count > 0 && samples.count <= m_batchSize);
    KeepFirstHalf();
    m_renderer.BeginFrame();
    const SceneIds ids = m_scene.Declare(samples.first);
    passes::TraceSettings settings = m_scene.SettingsFor(samples.first);
    settings.sampleCount = samples.count;
    if (ShowsLight())
        DeclareRadiance(ids, settings);
    else
        DeclareValues(ids, settings);
    for (uint32_t i = 0; i < samples.count && (m_isKeepingAlbedo || m_isKeepingNormal); ++i)
        DeclareAverages(ids, m_scene.SettingsFor(samples.first + i), i + 1 == samples.count);
    m_pending.push_back({m_renderer.Execute(), samples.count});
    if (!m_samples.empty() && m_samples.back().End() == samples.first)
        m_samples.back().count += samples.count;
    else
        m_samples = Union(m_samples, {samples});
    m_submitted += samples.count;
    m_hasPicture = false;
    NonFiniteSamples();
    m_times.Add(m_renderer.TakeTimings());
}

passes::AccumulatedIds SampleFrames::ReadBack(Accumulated& from, Extent2D extent,
                                              const std::optional<TextureId>& counts, bool withVariance) {
    const passes::AccumulatedIds ids = Resolve(from.accumulation, extent, withVariance, counts);
    from.mean = m_renderer.ReadBack(ids.mean);
    if (m_plan.withSums) from.sums = passes::SumsReadback(m_renderer, ids);
    if (withVariance) m_variance = m_renderer.ReadBack(ids.variance);
    return ids;
}

void SampleFrames::KeepFirstHalf() {
    constexpr uint32_t kLeast = 8;  // a smaller number gives no useful estimate
    if (!m_plan.NeedsGuides() || m_submitted < std::max(kLeast, 2 * m_firstHalves[1].count)) return;
    m_firstHalves[0] = std::move(m_firstHalves[1]);
    m_renderer.BeginFrame();
    m_firstHalves[1] = {
        m_submitted,
        passes::SumsReadback(m_renderer,
                             passes::StoredAccumulation(m_renderer, m_radiance.accumulation, Size(), false))};
    m_renderer.Execute();
}

void SampleFrames::RestoreFirstHalf(passes::Accumulation& into) {
    const FirstSamples* half = nullptr;
    for (const FirstSamples& kept : m_firstHalves)
        if (kept.count > 0 && uint64_t{3} * kept.count <= uint64_t{2} * m_submitted) half = &kept;
    if (half == nullptr) return;
    m_renderer.BeginFrame();
    passes::Restore(m_renderer, into, Size(), half->count, half->sums.Values());
    m_renderer.Execute();
}

passes::DenoiseInputs SampleFrames::DeclareDenoiseInputs(const SceneIds& scene,
                                                         const passes::AccumulatedIds& radiance,
                                                         TextureId albedo, TextureId normal,
                                                         const passes::Accumulation& firstHalf) {
    passes::DenoiseInputs inputs{radiance.mean, radiance.variance, albedo, normal, {}, {}};
    if (!m_scene.IsBlurred()) {
        const uint32_t first = m_samples.front().first;
        passes::TraceSettings settings = m_scene.SettingsFor(first);
        settings.sampleCount = m_submitted;
        const passes::GuideIds guides =
            passes::TraceGuides(m_renderer, scene, settings, radiance.mean, radiance.variance);
        inputs.albedo = guides.albedo;
        inputs.normal = guides.normal;
        // The guides trace one range of samples: a picture with gaps has others
        if (m_samples.size() == 1) inputs.seen = {guides.seen, guides.seenByAll, guides.seenSquares};
    }
    if (firstHalf.SampleCount() > 0)
        inputs.firstHalf = passes::Resolve(m_renderer, firstHalf, Size(), false).mean;
    return inputs;
}

void SampleFrames::ReadBackDenoising(const passes::DenoiseInputs& inputs, uint32_t firstSamples) {
    const auto readBack = [&](Texels DenoisingPlanes::*plane, TextureId from) {
        m_denoising.emplace_back(plane, m_renderer.ReadBack(from));
    };
    m_denoising.clear();
    m_firstSamples = firstSamples;
    readBack(&DenoisingPlanes::albedo, inputs.albedo);
    readBack(&DenoisingPlanes::normal, inputs.normal);
    if (inputs.firstHalf) readBack(&DenoisingPlanes::firstHalf, *inputs.firstHalf);
    if (!inputs.seen) return;
    readBack(&DenoisingPlanes::seen, inputs.seen->bySamples);
    readBack(&DenoisingPlanes::seenByAll, inputs.seen->byAll);
    readBack(&DenoisingPlanes::seenSquares, inputs.seen->squares);
}

TextureId SampleFrames::DeclareDisplay(TextureId mean, const SceneIds& scene) {
    if (!ShowsLight()) return passes::PaintView(m_renderer, mean, m_plan.view);
    std::optional<passes::Backdrop> backdrop;
    if (m_plan.backdrop) {
        const passes::TraceSettings settings = m_scene.SettingsFor(m_plan.firstSample);
        const passes::Region part =
            settings.region.IsEmpty() ? passes::WholeOf(settings.extent) : settings.region;
        backdrop = passes::DeclareBackdrop(m_renderer, scene, *m_plan.backdrop, m_blurred, settings.camera,
                                           settings.extent, part);
    }
    return passes::Tonemap(m_renderer, mean, m_plan.tonemap, backdrop);
}

void SampleFrames::FinishPicture() {
    m_hasPicture = true;
    if ((m_isKeepingCenter || m_isKeepingMotion) && !m_wasSharpTraced) TraceUnblurred();
    if (m_submitted == 0) return;
    RenderMissingUniformSamples();
    const Extent2D size = Size();
    passes::Accumulation firstHalf("firstHalf");
    if (m_plan.NeedsGuides()) RestoreFirstHalf(firstHalf);
    m_renderer.BeginFrame();
    SceneIds scene;
    if (m_plan.backdrop || (m_plan.NeedsGuides() && !m_scene.IsBlurred()))
        scene = m_scene.Declare(m_samples.front().first);
    const std::optional<TextureId> counts = DeclareCounts();
    if (m_adaptive) m_adaptive->ReadBack();
    const passes::AccumulatedIds radiance =
        ReadBack(m_radiance, size, counts, ShowsLight() && m_plan.withVariance);
    passes::AccumulatedIds albedo, normal;
    if (m_isKeepingAlbedo) albedo = ReadBack(m_albedo, size);
    if (m_isKeepingNormal) normal = ReadBack(m_normal, size);
    TextureId shown = radiance.mean;
    if (m_plan.NeedsGuides()) {
        const passes::DenoiseInputs inputs =
            DeclareDenoiseInputs(scene, radiance, albedo.mean, normal.mean, firstHalf);
        if (m_plan.aovs.Has(Aov::Denoising)) ReadBackDenoising(inputs, firstHalf.SampleCount());
        if (m_plan.isDenoised) {
            shown =
                passes::Denoise(m_renderer, inputs, {m_submitted, firstHalf.SampleCount(), m_plan.denoiser});
            m_denoised = m_renderer.ReadBack(shown);
        }
    }
    m_display = m_renderer.ReadBack(DeclareDisplay(shown, scene));
    for (KeptPart& part : m_parts) ReadBack(part.sum, size, counts);
    if (m_plan.lightGroupCount > 0) {
        const Extent2D tiles = passes::LightGroupTiles(m_plan.lightGroupCount);
        ReadBack(m_groups, {tiles.width * size.width, tiles.height * size.height}, counts);
    }
    if (ShowsLight()) m_secondTraces.ReadBack(m_renderer, size);
    m_renderer.Execute();
    if (firstHalf.SampleCount() == 0) return;
    firstHalf.Reset(passes::ResetCause::Start);
    passes::Release(m_renderer, firstHalf);
}

uint64_t SampleFrames::NonFiniteSamples() {
    for (; !m_counts.empty() && m_counts.front().counts.IsReady(); m_counts.pop_front()) {
        const auto counts = ValuesOf<passes::TraceCounts>(m_counts.front().counts).front();
        m_nonFiniteSamples += counts.nonFiniteSamples;
        m_rays += counts.Rays();
        m_paths += m_counts.front().paths;
    }
    return m_nonFiniteSamples;
}

std::optional<double> SampleFrames::RaysPerSample() {
    NonFiniteSamples();
    if (m_paths == 0) return std::nullopt;
    return static_cast<double>(m_rays) / static_cast<double>(m_paths);
}

void SampleFrames::WaitForSamples() {
    if (!m_pending.empty()) m_renderer.Device().WaitFor(m_pending.back().frame);
}

void SampleFrames::Take(const Accumulated& from, Texels& mean, passes::ExactSums& sums) const {
    mean = WaitForValues<float>(from.mean);
    if (m_plan.withSums) sums = from.sums.Values();
}

void SampleFrames::ZeroMeans(RenderFile& render) const {
    const passes::ExactSums zeros = passes::MakeExactSums(PixelCount(render.size), false);
    RenderSums& sums = render.sums;
    sums.radiance = passes::MakeExactSums(PixelCount(render.size), ShowsLight() && m_plan.withVariance);
    if (m_isKeepingAlbedo) sums.albedo = zeros;
    if (m_isKeepingNormal) sums.normal = zeros;
    for (const KeptPart& part : m_parts) sums.parts[part.index] = zeros;
    sums.lightGroups.assign(m_plan.lightGroupCount, zeros);
    render.lightGroups.resize(m_plan.lightGroupCount);
}

void SampleFrames::TakeMeans(RenderFile& render) const {
    Take(m_radiance, render.radiance, render.sums.radiance);
    if (ShowsLight() && m_plan.withVariance) render.variance = WaitForValues<float>(m_variance);
    if (m_plan.isDenoised) render.denoised = WaitForValues<float>(m_denoised);
    for (const auto& [plane, readback] : m_denoising)
        render.denoising.*plane = WaitForValues<float>(readback);
    render.denoising.firstSamples = m_firstSamples;
    if (m_isKeepingAlbedo) Take(m_albedo, render.albedo, render.sums.albedo);
    if (m_isKeepingNormal) Take(m_normal, render.normal, render.sums.normal);
    for (const KeptPart& part : m_parts)
        Take(part.sum, render.parts[part.index], render.sums.parts[part.index]);
    if (m_plan.lightGroupCount > 0) {
        Texels tiles;
        passes::ExactSums sums;
        Take(m_groups, tiles, sums);
        render.lightGroups = GroupsFromTiles(tiles, render.size, m_plan.lightGroupCount);
        if (m_plan.withSums)
            render.sums.lightGroups = GroupsFromTiles(sums, render.size, m_plan.lightGroupCount);
    }
}

void SampleFrames::TakePicture(RenderFile& render) const {
    if (m_submitted > 0)
        TakeMeans(render);
    else
        ZeroMeans(render);
    if (ShowsLight()) m_secondTraces.Take(render, m_plan.withSums);
    if (m_isKeepingCenter) {
        const std::vector<uint32_t> hits = WaitForValues<uint32_t>(m_ids);
        if (m_plan.aovs.Has(Aov::Depth)) render.depth = ChannelOf(WaitForValues<float>(m_position), 3);
        if (m_plan.aovs.Has(Aov::Instance)) render.instance = ChannelOf(hits, 0);
        if (m_plan.aovs.Has(Aov::Material)) render.material = ChannelOf(hits, 1);
    }
    if (m_isKeepingMotion)
        render.motion = MotionOf(WaitForValues<float>(m_placesAtOpen), WaitForValues<float>(m_placesAtClose));
    render.samples = m_samples;
    if (m_adaptive) render.adaptive = m_adaptive->Take();
}

void SampleFrames::DropPicture() {
    m_hasPicture = false;
    for (Accumulated* of : {&m_radiance, &m_albedo, &m_normal, &m_groups}) {
        of->mean = {};
        of->sums = {};
    }
    for (KeptPart& part : m_parts) {
        part.sum.mean = {};
        part.sum.sums = {};
    }
    m_variance = m_denoised = m_display = {};
    m_denoising.clear();
    m_secondTraces.DropReadbacks();
}

image::Image8 SampleFrames::TakeDisplay() const {
    const Extent2D size = m_display.Extent();
    return {size.width, size.height, WaitForValues<uint8_t>(m_display)};
}

image::Image8 SampleFrames::DisplayOf(const passes::ExactSums& sums, uint32_t sampleCount) {
    passes::Accumulation shown("shown");
    m_renderer.BeginFrame();
    passes::Restore(m_renderer, shown, Size(), sampleCount, {.sums = sums.sums, .squares = {}});
    m_renderer.Execute();
    m_renderer.BeginFrame();
    const TextureId mean = passes::Resolve(m_renderer, shown, Size(), false).mean;
    const SceneIds scene = m_plan.backdrop ? m_scene.Declare(m_plan.firstSample) : SceneIds{};
    m_display = m_renderer.ReadBack(DeclareDisplay(mean, scene));
    m_renderer.Execute();
    shown.Reset(passes::ResetCause::Start);
    passes::Release(m_renderer, shown);
    return TakeDisplay();
}

const PassTimes& SampleFrames::Times() {
    WaitForSamples();
    m_times.Add(m_renderer.TakeTimings());
    return m_times;
}

// --- Adaptive pictures ---

void SampleFrames::RenderAdaptive(uint32_t average, uint32_t most) {
    const uint32_t next = m_submitted + std::min(average - m_submitted, most);
    while (m_adaptive->PrepareFor(next, m_radiance.accumulation)) RenderListed(next);
}

void SampleFrames::RenderListed(uint32_t average) {
    const bool hasGroups = m_plan.lightGroupCount > 0;
    const uint32_t tiles = hasGroups ? passes::LightGroupTiles(m_plan.lightGroupCount).height : 1;
    m_renderer.BeginFrame();
    const SceneIds ids = m_scene.Declare(m_plan.firstSample);
    const AdaptiveFrames::Samples samples =
        m_adaptive->Take(m_radiance.accumulation, average, PixelCount(Size()) * m_batchSize,
                         m_renderer.Device().Info().maxTextureExtent / tiles);
    passes::TraceSettings settings = m_scene.SettingsFor(samples.index);
    settings.sampleCount = samples.count;
    settings.pixels = samples.pixels;
    DeclareRadiance(ids, settings);
    DeclareUniformSamples(ids);
    m_pending.push_back({m_renderer.Execute(), uint64_t{samples.count} * samples.pixels.count});
    m_submitted = m_adaptive->Counts().Average();
    m_samples = {{m_plan.firstSample, m_submitted}};
    m_hasPicture = false;
    NonFiniteSamples();
    m_times.Add(m_renderer.TakeTimings());
}

void SampleFrames::DeclareUniformSamples(const SceneIds& ids) {
    // Each of them has passes for each sample
    constexpr uint32_t kAtOnce = 16;
    const bool hasAverages = m_isKeepingAlbedo || m_isKeepingNormal;
    const uint32_t end = std::min(m_adaptive->Counts().MinimumCount(), m_uniformSamples + kAtOnce);
    for (; m_uniformSamples < end; ++m_uniformSamples) {
        const uint32_t index = m_plan.firstSample + m_uniformSamples;
        const passes::TraceSettings settings = m_scene.SettingsFor(index);
        if (hasAverages) DeclareAverages(ids, settings, m_uniformSamples + 1 == end);
        if (m_secondTraces.HasAny() && index % kSecondTracePeriod == 0)
            m_secondTraces.Declare(m_renderer, settings, DeclareSamples(ids, settings).radiance,
                                   [&](const auto& others) { return DeclareSamples(ids, others).radiance; });
    }
}

// Renders the surfaces that the last frames of samples left out.
void SampleFrames::RenderMissingUniformSamples() {
    while (m_adaptive && m_uniformSamples < m_adaptive->Counts().MinimumCount()) {
        m_renderer.BeginFrame();
        DeclareUniformSamples(m_scene.Declare(m_plan.firstSample));
        m_renderer.Execute();
    }
}

uint32_t SampleFrames::SamplesDone() {
    while (!m_pending.empty() && m_renderer.Device().HasCompleted(m_pending.front().frame))
        m_pending.pop_front();
    uint64_t pending = 0;
    for (const PendingSamples& samples : m_pending) pending += samples.count;
    if (m_adaptive)
        return static_cast<uint32_t>((m_adaptive->Counts().Total() - pending) / PixelCount(Size()));
    return m_submitted - static_cast<uint32_t>(pending);
}

std::optional<TextureId> SampleFrames::DeclareCounts() {
    if (!m_adaptive) return std::nullopt;
    return m_adaptive->CountsTexture();
}

passes::AccumulatedIds SampleFrames::Resolve(const passes::Accumulation& accumulation, Extent2D extent,
                                             bool withVariance, const std::optional<TextureId>& counts) {
    if (counts) return passes::Resolve(m_renderer, accumulation, *counts, extent, withVariance);
    return passes::Resolve(m_renderer, accumulation, extent, withVariance);
}

// --- Measuring the error of the picture ---

void SampleFrames::MeasureError() {
    if (m_measurement || !m_plan.withVariance || !ShowsLight()) return;
    m_renderer.BeginFrame();
    const passes::AccumulatedIds ids = Resolve(m_radiance.accumulation, Size(), true, DeclareCounts());
    m_measurement = Measurement{m_submitted, m_renderer.ReadBack(ids.mean), m_renderer.ReadBack(ids.variance),
                                m_adaptive ? m_adaptive->Counts().State().counts : std::vector<uint32_t>{}};
    m_renderer.Execute();
}

MeasuredError SampleFrames::MeasureErrorNow() {
    if (m_measurement && m_measurement->sampleCount != m_submitted) m_measurement.reset();
    MeasureError();
    RG_CHECK(m_measurement.has_value());
    m_measurement->mean.Wait();
    m_measurement->variance.Wait();
    return *NewestError();
}

const std::optional<MeasuredError>& SampleFrames::NewestError() {
    if (m_measurement && m_measurement->mean.IsReady() && m_measurement->variance.IsReady()) {
        m_error = session::MeasureError(WaitForValues<float>(m_measurement->mean),
                                        WaitForValues<float>(m_measurement->variance),
                                        m_measurement->sampleCount, m_measurement->counts);
        m_measurement.reset();
    }
    return m_error;
}

passes::ExactSums SampleFrames::RadianceSums() {
    if (m_submitted == 0) return passes::MakeExactSums(PixelCount(Size()), true);
    m_renderer.BeginFrame();
    const passes::SumsReadback sums(m_renderer,
                                    passes::Resolve(m_renderer, m_radiance.accumulation, Size(), true));
    m_renderer.Execute();
    return sums.Values();
}

double ShutterPosition(uint32_t sampleIndex, uint32_t seed) {
    const uint32_t scramble = gpu::MixBits(seed ^ 0x5bd1e995u);
    uint32_t above = 1;  // the bits so far, behind a leading 1 that tells their number
    double position = 0.0, half = 0.5;
    for (uint32_t bit = 0; bit < 32; ++bit, half *= 0.5) {
        const uint32_t unscrambled = (sampleIndex >> bit) & 1u;
        const uint32_t flip = gpu::MixBits(above ^ gpu::MixBits(scramble + bit)) & 1u;
        if ((unscrambled ^ flip) != 0) position += half;
        above = (above << 1u) | unscrambled;
    }
    return position;
}

// --- Tiles of groups of lights ---

namespace {

// Calls copy(row of the picture, the same row in the tiles) with the positions of their first floats.
template <typename Copy>
void ForEachRow(Extent2D size, uint32_t groupCount, uint32_t group, const Copy& copy) {
    const uint32_t columns = passes::LightGroupTiles(groupCount).width;
    for (uint32_t y = 0; y < size.height; ++y) {
        const size_t tileRow = size_t{group / columns} * size.height + y;
        copy(4 * size_t{y} * size.width, 4 * size_t{size.width} * (tileRow * columns + group % columns));
    }
}

}  // namespace

std::vector<Texels> GroupsFromTiles(const Texels& tiles, Extent2D size, uint32_t groupCount) {
    std::vector<Texels> pictures(groupCount, Texels(4 * PixelCount(size)));
    for (uint32_t group = 0; group < groupCount; ++group)
        ForEachRow(size, groupCount, group, [&](size_t to, size_t from) {
            std::copy_n(tiles.data() + from, 4 * size_t{size.width}, pictures[group].data() + to);
        });
    return pictures;
}

std::vector<passes::ExactSums> GroupsFromTiles(const passes::ExactSums& tiles, Extent2D size,
                                               uint32_t groupCount) {
    std::vector<passes::ExactSums> pictures(groupCount, passes::MakeExactSums(PixelCount(size), false));
    for (uint32_t group = 0; group < groupCount; ++group)
        for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k)
            ForEachRow(size, groupCount, group, [&](size_t to, size_t from) {
                std::copy_n(tiles.sums[k].data() + from, 4 * size_t{size.width},
                            pictures[group].sums[k].data() + to);
            });
    return pictures;
}

passes::ExactSums TilesFromGroups(const std::vector<passes::ExactSums>& pictures, Extent2D size) {
    const uint32_t count = static_cast<uint32_t>(pictures.size());
    const Extent2D across = passes::LightGroupTiles(count);
    passes::ExactSums tiles = passes::MakeExactSums(PixelCount(size) * across.width * across.height, false);
    for (uint32_t group = 0; group < count; ++group)
        for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k)
            ForEachRow(size, count, group, [&](size_t from, size_t to) {
                std::copy_n(pictures[group].sums[k].data() + from, 4 * size_t{size.width},
                            tiles.sums[k].data() + to);
            });
    return tiles;
}

}  // namespace raygraph::session
