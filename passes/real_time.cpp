#include "passes/real_time.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "passes/compare.h"
#include "passes/scene_bindings.h"
#include "renderer/gpu_scene/camera_record.h"

namespace raygraph::passes {

namespace {

constexpr uint32_t kNoLimit = std::numeric_limits<uint32_t>::max();
constexpr float kNothingWritten[] = {0.0f, 0.0f, 0.0f, -1.0f};  // of surfaces
constexpr float kZero[] = {0.0f, 0.0f, 0.0f, 0.0f};

// Mirrors the struct of that name in shaders/real_time/surface.glsl.
struct Film {
    glm::vec3 right, up, forward;
    uint32_t isOrthographic;
    glm::vec2 size;
};

Film FilmOf(const gpu::CameraRecord& camera, Extent2D extent) {
    return {camera.right, camera.up, camera.forward, camera.orthographic,
            glm::vec2(static_cast<float>(extent.width), static_cast<float>(extent.height))};
}

bool IsSameView(const gpu::CameraRecord& a, const gpu::CameraRecord& b) {
    return a.orthographic == b.orthographic && a.right == b.right && a.up == b.up && a.forward == b.forward &&
           a.lensRadius == b.lensRadius && a.focusDistance == b.focusDistance;
}

}  // namespace

SurfaceIds TraceSurfaces(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                         const SceneBefore& before, TextureId surfaces) {
    RequireFullFrame(settings, "TraceSurfaces");
    const Extent2D extent = settings.extent;
    const auto create = [&](const char* name) {
        return renderer.CreateTexture(name, {extent, Format::Rgba32Float});
    };
    SurfaceIds seen{create("albedo"), surfaces.IsValid() ? surfaces : create("surfaces"), create("motion")};
    TraceFeatures features = ProgramFeatures(scene, settings);
    features = features & (FeaturesOfKind(TraceFeatureKind::Textures) | kTraceAnyHit | kTraceCapsules |
                           kTraceTextureLod);
    const bool isDeformed = scene.deformedStreams.IsValid() && before.deformedStreams.IsValid();
    const uint64_t deformedBytes = isDeformed ? renderer.Desc(scene.deformedStreams).size : 0;
    renderer.AddPass(
        "TraceSurfaces", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen("real_time/surfaces.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            SpecializeFeatures(pass, features);
            BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::On);
            BindGeometry(pass, scene);
            BindMaterials(pass, scene);
            pass.Reads("instancesBefore", before.instances);
            pass.Reads("deformed", isDeformed ? scene.deformedStreams : scene.instances);
            pass.Reads("deformedBefore", isDeformed ? before.deformedStreams : before.instances);
            pass.Constants(deformedBytes);
            pass.Uniform("before", before.camera);
            seen.albedo = pass.Writes("albedo", seen.albedo);
            seen.surfaces = pass.Writes("surfaces", seen.surfaces);
            seen.motion = pass.Writes("motion", seen.motion);
        },
        [extent](CommandList& commands) { commands.TraceRays(extent); });
    return seen;
}

MovingMeanIds AccumulateMoving(Renderer& renderer, TextureId sample, const SurfaceIds& seen,
                               const MovingMeanIds& before, const gpu::CameraRecord& cameraBefore,
                               uint32_t mostBefore, uint32_t most, const MovingMeanIds& into) {
    const Extent2D extent =
        RequireComparable(renderer, "RealTime", seen.albedo,
                          {seen.surfaces, seen.motion, before.mean, before.surfaces}, Format::Rgba32Float);
    MovingMeanIds now{into.mean, into.square, seen.surfaces};
    if (!now.mean.IsValid()) now.mean = renderer.CreateTexture("mean", {extent, Format::Rgba32Float});
    if (!now.square.IsValid()) now.square = renderer.CreateTexture("square", {extent, Format::R32Float});
    const struct {
        Film film;
        float mostBefore, most;
    } constants{FilmOf(cameraBefore, extent), static_cast<float>(mostBefore), static_cast<float>(most)};
    renderer.AddPass(
        "AccumulateMoving", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("real_time/temporal.comp");
            pass.Reads("radiance", sample);
            pass.Reads("albedo", seen.albedo);
            pass.Reads("surfaces", seen.surfaces);
            pass.Reads("motion", seen.motion);
            pass.Reads("surfacesBefore", before.surfaces);
            pass.Reads("meanBefore", before.mean);
            pass.Reads("squareBefore", before.square);
            pass.Constants(constants);
            now.mean = pass.Writes("mean", now.mean);
            now.square = pass.Writes("square", now.square);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return now;
}

TextureId EstimateVariance(Renderer& renderer, const MovingMeanIds& mean, TextureId albedo) {
    const Extent2D extent =
        RequireComparable(renderer, "RealTime", mean.mean, {mean.surfaces, albedo}, Format::Rgba32Float);
    TextureId guided = renderer.CreateTexture("guided", {extent, Format::Rgba32Float});
    renderer.AddPass(
        "EstimateVariance", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("real_time/variance.comp");
            pass.Reads("mean", mean.mean);
            pass.Reads("square", mean.square);
            pass.Reads("surfaces", mean.surfaces);
            pass.Reads("albedo", albedo);
            guided = pass.Writes("guided", guided);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return guided;
}

TextureId FilterLevel(Renderer& renderer, TextureId guided, TextureId surfaces,
                      const gpu::CameraRecord& camera, uint32_t stride) {
    const Extent2D extent = RequireComparable(renderer, "RealTime", guided, {surfaces}, Format::Rgba32Float);
    TextureId filtered = renderer.CreateTexture("filtered", {extent, Format::Rgba32Float});
    const struct {
        Film film;
        int32_t stride;
    } constants{FilmOf(camera, extent), static_cast<int32_t>(stride)};
    renderer.AddPass(
        "FilterLevel", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("real_time/filter.comp");
            pass.Reads("guided", guided);
            pass.Reads("surfaces", surfaces);
            pass.Constants(constants);
            filtered = pass.Writes("filtered", filtered);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return filtered;
}

TextureId ResolveMoving(Renderer& renderer, TextureId filtered, const SurfaceIds& seen, TextureId mean,
                        TextureId surfacesBefore, TextureId pictureBefore, const ResolveSettings& settings,
                        TextureId picture) {
    const Extent2D extent = RequireComparable(
        renderer, "RealTime", filtered,
        {seen.albedo, seen.surfaces, seen.motion, mean, surfacesBefore, pictureBefore}, Format::Rgba32Float);
    if (!picture.IsValid()) picture = renderer.CreateTexture("picture", {extent, Format::Rgba32Float});
    const struct {
        float mostBefore, mostMoving, mostStill;
        uint32_t hasChanged;
    } constants{static_cast<float>(settings.mostBefore), static_cast<float>(settings.mostMoving),
                static_cast<float>(settings.mostStill), settings.hasChanged ? 1u : 0u};
    renderer.AddPass(
        "ResolveMoving", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("real_time/resolve.comp");
            pass.Reads("filtered", filtered);
            pass.Reads("albedo", seen.albedo);
            pass.Reads("surfaces", seen.surfaces);
            pass.Reads("motion", seen.motion);
            pass.Reads("mean", mean);
            pass.Reads("surfacesBefore", surfacesBefore);
            pass.Reads("pictureBefore", pictureBefore);
            pass.Constants(constants);
            picture = pass.Writes("picture", picture);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return picture;
}

// --- RealTime ---

void RealTimeHistory::Limit(uint32_t samples) {
    m_limit = std::min(m_limit.value_or(samples), samples);
}

// The declaration of one frame.
class RealTimeFrame {
  public:
    RealTimeFrame(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                  RealTimeHistory& history, const RealTimeSettings& realTime)
        : m_renderer(renderer), m_scene(scene), m_settings(settings), m_history(history), m_of(realTime) {
        m_instances = Kept("instances", scene.instances);
        if (scene.deformedStreams.IsValid()) m_deformed = Kept("deformed", scene.deformedStreams);
        m_before = Persistent(false);
        m_now = Persistent(true);
        m_camera = ParametersFor(scene, settings).camera;
        m_hasInstances =
            !renderer.IsFresh(m_instances) && !(m_deformed.IsValid() && renderer.IsFresh(m_deformed));
        const bool isFresh = renderer.IsFresh(m_before.mean.mean);
        if (m_hasInstances && !isFresh && history.m_before && history.m_before->extent == settings.extent)
            m_limit = history.m_limit.value_or(kNoLimit);
        if (!m_hasInstances) KeepInstances();
        if (!isFresh) return;
        Clear(m_before.mean.surfaces, kNothingWritten);
        Clear(m_before.mean.mean, kZero);
        Clear(m_before.mean.square, kZero);
        Clear(m_before.picture, kZero);
    }

    TextureId Declare(TextureId sample) {
        const gpu::CameraRecord before = m_limit > 0 ? m_history.m_before->camera : m_camera;
        const SurfaceIds seen = TraceSurfaces(m_renderer, m_scene, m_settings,
                                              {before, m_instances, m_deformed}, m_now.mean.surfaces);
        const MovingMeanIds mean =
            AccumulateMoving(m_renderer, sample, seen, m_before.mean, before,
                             std::min(m_limit, m_of.mostSamples), m_of.mostSamples, m_now.mean);
        TextureId filtered = EstimateVariance(m_renderer, mean, seen.albedo);
        for (uint32_t level = 0; level < m_of.filterLevels; ++level)
            filtered = FilterLevel(m_renderer, filtered, mean.surfaces, m_camera, 1u << level);
        const uint32_t mostFrames = std::max(m_of.mostFramesMoving, m_of.mostFramesStill);
        const TextureId picture =
            ResolveMoving(m_renderer, filtered, seen, mean.mean, m_before.mean.surfaces, m_before.picture,
                          {.mostBefore = std::min(m_limit, mostFrames),
                           .mostMoving = m_of.mostFramesMoving,
                           .mostStill = m_of.mostFramesStill,
                           .hasChanged = m_history.m_limit.has_value()},
                          m_now.picture);
        if (m_hasInstances) KeepInstances();
        return picture;
    }

  private:
    struct Textures {
        MovingMeanIds mean;
        TextureId picture;
    };
    Textures Persistent(bool isNext) {
        const auto persist = [&](const char* part, Format format) {
            return m_renderer.Persist(m_history.NameOf(part, isNext), {m_settings.extent, format});
        };
        return {{persist("mean", Format::Rgba32Float), persist("square", Format::R32Float),
                 persist("surfaces", Format::Rgba32Float)},
                persist("picture", Format::Rgba32Float)};
    }

    BufferId Kept(const char* part, BufferId of) {
        return m_renderer.PersistBuffer(m_history.Name() + "." + part, {.size = m_renderer.Desc(of).size});
    }

    void Clear(TextureId& texture, const float (&rgba)[4]) {
        m_renderer.AddPass(
            "ClearHistory", PassKind::Transfer, [&](PassBuilder& pass) { texture = pass.CopiesTo(texture); },
            [texture, &rgba](CommandList& commands, const PassResources& resources) {
                commands.Clear(resources.Texture(texture), rgba);
            });
    }

    // Keeps instances and deformed vertices for the next frame, which they tell from where everything has
    // moved. The pass is executed if the picture is shown, which needs what it overwrites or, in the first
    // frame, what it writes.
    void KeepInstances() {
        const bool isStill = m_limit > 0 && !m_history.m_limit &&
                             IsSameView(m_history.m_before->camera, m_camera) &&
                             m_history.m_before->eye == EyeOf(m_settings.camera);
        struct Copy {
            BufferId from, to;
            uint64_t bytes;
        };
        std::vector<Copy> copies{{m_scene.instances, m_instances, m_renderer.Desc(m_instances).size}};
        if (m_deformed.IsValid())
            copies.push_back({m_scene.deformedStreams, m_deformed, m_renderer.Desc(m_deformed).size});
        m_renderer.AddPass(
            "KeepInstances", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(m_scene.instances);
                m_instances = pass.CopiesTo(m_instances);
                if (!m_deformed.IsValid()) return;
                pass.CopiesFrom(m_scene.deformedStreams);
                m_deformed = pass.CopiesTo(m_deformed);
            },
            [copies, &history = m_history, isStill,
             frame = RealTimeHistory::Frame{m_settings.extent, m_camera, EyeOf(m_settings.camera)}](
                CommandList& commands, const PassResources& resources) {
                for (const Copy& copy : copies)
                    commands.CopyBuffer(resources.Buffer(copy.from), 0, resources.Buffer(copy.to), 0,
                                        copy.bytes);
                commands.OnSubmitted([&history, isStill, frame] {
                    history.m_before = frame;
                    history.m_isOdd = !history.m_isOdd;
                    history.m_limit.reset();
                    history.m_stillFrames = isStill ? history.m_stillFrames + 1 : 0;
                });
            });
    }

    Renderer& m_renderer;
    const SceneIds& m_scene;
    const TraceSettings& m_settings;
    RealTimeHistory& m_history;
    const RealTimeSettings& m_of;
    gpu::CameraRecord m_camera;
    uint32_t m_limit = 0;  // 0: there is nothing before
    bool m_hasInstances = false;
    BufferId m_instances, m_deformed;
    Textures m_before, m_now;
};

TextureId RealTime(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, TextureId sample,
                   RealTimeHistory& history, const RealTimeSettings& realTime) {
    return RealTimeFrame(renderer, scene, settings, history, realTime).Declare(sample);
}

TextureId LastRealTime(Renderer& renderer, const RealTimeHistory& history, Extent2D extent) {
    return renderer.Persist(history.NameOf("picture", false), {extent, Format::Rgba32Float});
}

TextureId HandOver(Renderer& renderer, TextureId picture, const AccumulatedIds& samples,
                   const Accumulation::Progress& progress) {
    constexpr uint32_t kBlock = 8;  // as in real_time/hand_over.glsl
    const Extent2D extent =
        RequireComparable(renderer, "RealTime", picture, {samples.mean}, Format::Rgba32Float);
    const Extent2D blocks{(extent.width + kBlock - 1) / kBlock, (extent.height + kBlock - 1) / kBlock};
    const struct {
        uint32_t sampleCount, doneRows, doneColumns, bandHeight;
    } constants{progress.sampleCount, progress.cursor.Y(), progress.cursor.X(), progress.cursor.BandHeight()};
    TextureId weights = renderer.CreateTexture("handOverWeights", {blocks, Format::R32Float});
    renderer.AddPass(
        "HandOverWeights", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("real_time/hand_over_weights.comp");
            pass.Reads("picture", picture);
            ReadSums(pass, samples, true);
            pass.Constants(constants);
            weights = pass.Writes("weights", weights);
        },
        [blocks](CommandList& commands) { commands.DispatchOver(blocks); });
    TextureId shown = renderer.CreateTexture("handedOver", {extent, Format::Rgba32Float});
    renderer.AddPass(
        "HandOver", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("real_time/hand_over.comp");
            pass.Reads("picture", picture);
            pass.Reads("reference", samples.mean);
            pass.Reads("weights", weights);
            pass.Constants(constants);
            shown = pass.Writes("shown", shown);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return shown;
}

void Release(Renderer& renderer, RealTimeHistory& history) {
    for (const char* part : {"instances", "deformed"}) renderer.Release(history.Name() + "." + part);
    for (const char* part : {"surfaces", "mean", "square", "picture"})
        for (const bool isNext : {false, true}) renderer.Release(history.NameOf(part, isNext));
    history = RealTimeHistory(history.Name());
}

}  // namespace raygraph::passes
