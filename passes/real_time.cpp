#include "passes/real_time.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <vector>

#include "base/text.h"
#include "passes/add_compute.h"
#include "passes/scene_bindings.h"
#include "renderer/gpu_scene/camera_record.h"
#include "shaders/shared/real_time.h"

namespace raygraph::passes {

namespace {

// The formats of shaders/real_time.
constexpr Format kColors = Format::Rgba16Float;  // albedo, motion, means and pictures
constexpr Format kDeviations = Format::R16Float;
constexpr Format kSurfaces = Format::Rg32Uint;

gpu::Film FilmOf(const gpu::CameraRecord& camera, Extent2D extent) {
    return {camera.right, camera.up, camera.forward, camera.orthographic,
            glm::vec2(static_cast<float>(extent.width), static_cast<float>(extent.height))};
}

bool IsSameView(const gpu::CameraRecord& a, const gpu::CameraRecord& b) {
    return a.orthographic == b.orthographic && a.right == b.right && a.up == b.up && a.forward == b.forward;
}

bool IsSameLens(const gpu::CameraRecord& a, const gpu::CameraRecord& b) {
    return a.lensRadius == b.lensRadius && a.focusDistance == b.focusDistance;
}

// Returns the extent that all of them have. Throws Error{Usage} if they differ; formats are those of the
// shaders.
Extent2D ExtentOfAll(const Renderer& renderer, std::initializer_list<TextureId> textures) {
    const Extent2D extent = renderer.Desc(*textures.begin()).extent;
    for (const TextureId texture : textures)
        if (const Extent2D other = renderer.Desc(texture).extent; !(other == extent))
            throw MakeError(ErrorKind::Usage, "RealTime: a texture of {}x{} beside one of {}x{}", other.width,
                            other.height, extent.width, extent.height);
    return extent;
}

// Returns `given`, or a new texture in its place.
TextureId TextureOr(TextureId given, Renderer& renderer, const char* name, Extent2D extent, Format format) {
    return given.IsValid() ? given : renderer.CreateTexture(name, {extent, format});
}

// Declares what a shader needs to find the history of a sample.
void ReadSampleAndHistory(PassBuilder& pass, TextureId sample, const SurfaceIds& seen,
                          const MovingMeanIds& before) {
    pass.Reads("radiance", sample);
    pass.Reads("albedo", seen.albedo);
    pass.Reads("surfaces", seen.surfaces);
    pass.Reads("motion", seen.motion);
    pass.Reads("surfacesBefore", before.surfaces);
    pass.Reads("meanBefore", before.mean);
}

}  // namespace

SurfaceIds TraceSurfaces(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                         const SceneBefore& before, TextureId surfaces) {
    RequireFullFrame(settings, "TraceSurfaces");
    const Extent2D extent = settings.extent;
    SurfaceIds seen{renderer.CreateTexture("albedo", {extent, kColors}),
                    TextureOr(surfaces, renderer, "surfaces", extent, kSurfaces),
                    renderer.CreateTexture("motion", {extent, kColors})};
    TraceFeatures features = ProgramFeatures(scene, settings);
    features =
        features & (FeaturesOfKind(TraceFeatureKind::Textures) | kTraceMetals | kTraceGlass | kTraceVolumes |
                    kTraceScattering | kTraceAnyHit | kTraceCapsules | kTraceTextureLod);
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

TextureId FindChanges(Renderer& renderer, TextureId sample, const SurfaceIds& seen,
                      const MovingMeanIds& before) {
    const Extent2D extent =
        ExtentOfAll(renderer, {seen.albedo, seen.surfaces, seen.motion, before.mean, before.surfaces});
    TextureId changes =
        renderer.CreateTexture("changes", {BlocksOf(extent, gpu::kChangeBlock), Format::Rgba32Float});
    AddCompute(renderer, "FindChanges", "real_time/changes.comp", extent, [&](PassBuilder& pass) {
        ReadSampleAndHistory(pass, sample, seen, before);
        changes = pass.Writes("changes", changes);
    });
    return changes;
}

MovingMeanIds AccumulateMoving(Renderer& renderer, TextureId sample, const SurfaceIds& seen,
                               const MovingMeanIds& before, const MovingMeanSettings& settings,
                               const MovingMeanIds& into) {
    const Extent2D extent = ExtentOfAll(
        renderer, {seen.albedo, seen.surfaces, seen.motion, before.mean, before.deviation, before.surfaces});
    MovingMeanIds now{TextureOr(into.mean, renderer, "mean", extent, kColors),
                      TextureOr(into.deviation, renderer, "deviation", extent, kDeviations), seen.surfaces};
    const struct {
        gpu::Film film;
        float mostBefore, most;
        uint32_t frame, hasChanges;
    } constants{FilmOf(settings.cameraBefore, extent), static_cast<float>(settings.mostBefore),
                static_cast<float>(settings.most), settings.frame, settings.changes.IsValid() ? 1u : 0u};
    AddCompute(renderer, "AccumulateMoving", "real_time/temporal.comp", extent, [&](PassBuilder& pass) {
        ReadSampleAndHistory(pass, sample, seen, before);
        pass.Reads("deviationBefore", before.deviation);
        pass.Reads("changes", settings.changes.IsValid() ? settings.changes : sample);
        pass.Constants(constants);
        now.mean = pass.Writes("mean", now.mean);
        now.deviation = pass.Writes("deviation", now.deviation);
    });
    return now;
}

TextureId EstimateVariance(Renderer& renderer, const MovingMeanIds& mean, TextureId albedo, TextureId into) {
    const Extent2D extent = ExtentOfAll(renderer, {mean.mean, mean.deviation, mean.surfaces, albedo});
    TextureId guided = TextureOr(into, renderer, "guided", extent, kColors);
    AddCompute(renderer, "EstimateVariance", "real_time/variance.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("mean", mean.mean);
        pass.Reads("deviation", mean.deviation);
        pass.Reads("surfaces", mean.surfaces);
        pass.Reads("albedo", albedo);
        guided = pass.Writes("guided", guided);
    });
    return guided;
}

TextureId FilterLevel(Renderer& renderer, TextureId guided, TextureId surfaces,
                      const gpu::CameraRecord& camera, glm::ivec2 step, TextureId into) {
    const Extent2D extent = ExtentOfAll(renderer, {guided, surfaces});
    TextureId filtered = TextureOr(into, renderer, "filtered", extent, kColors);
    const struct {
        gpu::Film film;
        glm::ivec2 step;
    } constants{FilmOf(camera, extent), step};
    AddCompute(renderer, "FilterLevel", "real_time/filter.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("guided", guided);
        pass.Reads("surfaces", surfaces);
        pass.Constants(constants);
        filtered = pass.Writes("filtered", filtered);
    });
    return filtered;
}

TextureId ResolveMoving(Renderer& renderer, TextureId filtered, const SurfaceIds& seen, TextureId mean,
                        TextureId surfacesBefore, TextureId pictureBefore, const ResolveSettings& settings,
                        TextureId into) {
    const Extent2D extent = ExtentOfAll(
        renderer, {filtered, seen.albedo, seen.surfaces, seen.motion, mean, surfacesBefore, pictureBefore});
    TextureId picture = TextureOr(into, renderer, "picture", extent, kColors);
    const struct {
        float mostBefore, mostMoving, mostStill;
        uint32_t hasChanged, isStill, hasLimit, frame;
    } constants{static_cast<float>(settings.mostBefore),
                static_cast<float>(settings.mostMoving),
                static_cast<float>(settings.mostStill),
                settings.hasChanged ? 1u : 0u,
                settings.isStill ? 1u : 0u,
                settings.hasLimit ? 1u : 0u,
                settings.frame};
    AddCompute(renderer, "ResolveMoving", "real_time/resolve.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("filtered", filtered);
        pass.Reads("albedo", seen.albedo);
        pass.Reads("surfaces", seen.surfaces);
        pass.Reads("motion", seen.motion);
        pass.Reads("mean", mean);
        pass.Reads("surfacesBefore", surfacesBefore);
        pass.Reads("pictureBefore", pictureBefore);
        pass.Constants(constants);
        picture = pass.Writes("picture", picture);
    });
    return picture;
}

// --- RealTime ---

// The declaration of one frame.
class RealTimeFrame {
    using Change = RealTimeHistory::Change;

  public:
    RealTimeFrame(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                  RealTimeHistory& history, const RealTimeSettings& realTime)
        : m_renderer(renderer),
          m_scene(scene),
          m_settings(settings),
          m_history(history),
          m_realTime(realTime) {
        m_instances = Kept("instances", scene.instances);
        if (scene.deformedStreams.IsValid()) m_deformed = Kept("deformed", scene.deformedStreams);
        m_before = Persistent(false);
        m_now = Persistent(true);
        m_camera = ParametersFor(scene, settings).camera;
        m_hasInstances =
            !renderer.IsFresh(m_instances) && !(m_deformed.IsValid() && renderer.IsFresh(m_deformed));
        const bool isFresh = renderer.IsFresh(m_before.mean.mean);
        m_hasHistory = m_hasInstances && !isFresh && m_history.m_change != Change::Forget &&
                       history.m_before && history.m_before->extent == settings.extent;
        // Another lens moves no surface, but pictures before it are as sharp as the one before was
        m_hasChanged = history.m_change != Change::None ||
                       (m_hasHistory && !IsSameLens(history.m_before->camera, m_camera));
        m_changeFrames = m_hasChanged ? RealTimeHistory::kFramesOfChange : history.m_changeFrames;
        m_isStill = m_hasHistory && !m_hasChanged && IsSameView(history.m_before->camera, m_camera) &&
                    history.m_before->eye == EyeOf(settings.camera);
        if (!m_hasInstances) KeepInstances();
        if (!isFresh) return;
        for (TextureId* plane :
             {&m_before.mean.surfaces, &m_before.mean.mean, &m_before.mean.deviation, &m_before.picture})
            Clear(*plane);
    }

    TextureId Declare(TextureId sample) {
        const gpu::CameraRecord before = m_hasHistory ? m_history.m_before->camera : m_camera;
        const SurfaceIds seen = TraceSurfaces(m_renderer, m_scene, m_settings,
                                              {before, m_instances, m_deformed}, m_now.mean.surfaces);
        TextureId changes;
        if (m_hasHistory && m_changeFrames > 0)
            changes = FindChanges(m_renderer, sample, seen, m_before.mean);
        const MovingMeanIds mean = AccumulateMoving(m_renderer, sample, seen, m_before.mean,
                                                    {.cameraBefore = before,
                                                     .mostBefore = m_hasHistory ? m_realTime.mostSamples : 0,
                                                     .most = m_realTime.mostSamples,
                                                     .frame = m_history.m_frameCount,
                                                     .changes = changes},
                                                    m_now.mean);
        // The filter's levels lie where nothing is needed any more, and where the picture will be: the last
        // one where it is not
        std::array levels{m_before.mean.mean, m_now.picture};
        const auto into = [&](uint32_t level) -> TextureId& {
            return levels[(m_realTime.filterLevels - level) % 2];
        };
        TextureId filtered = into(0) = EstimateVariance(m_renderer, mean, seen.albedo, into(0));
        for (uint32_t level = 0; level < m_realTime.filterLevels; ++level)
            filtered = into(level + 1) =
                FilterLevel(m_renderer, filtered, mean.surfaces, m_camera, {1 << level, 0}, into(level + 1));
        const uint32_t mostFrames = std::max(m_realTime.mostFramesMoving, m_realTime.mostFramesStill);
        const TextureId picture =
            ResolveMoving(m_renderer, filtered, seen, mean.mean, m_before.mean.surfaces, m_before.picture,
                          {.mostBefore = m_hasHistory ? mostFrames : 0,
                           .mostMoving = m_realTime.mostFramesMoving,
                           .mostStill = m_realTime.mostFramesStill,
                           .hasChanged = m_hasChanged,
                           .isStill = m_isStill,
                           .hasLimit = changes.IsValid(),
                           .frame = m_history.m_frameCount},
                          levels[1]);
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
        return {{persist("mean", kColors), persist("deviation", kDeviations), persist("surfaces", kSurfaces)},
                persist("picture", kColors)};
    }

    BufferId Kept(const char* part, BufferId of) {
        return m_renderer.PersistBuffer(m_history.Name() + "." + part, {.size = m_renderer.Desc(of).size});
    }

    void Clear(TextureId& texture) {
        m_renderer.AddPass(
            "ClearHistory", PassKind::Transfer, [&](PassBuilder& pass) { texture = pass.CopiesTo(texture); },
            [texture](CommandList& commands, const PassResources& resources) {
                commands.Clear(resources.Texture(texture), {0.0f, 0.0f, 0.0f, 0.0f});
            });
    }

    // Keeps instances and deformed vertices for the next frame, which they tell from where everything has
    // moved. The pass is executed if the picture is shown, which needs what it overwrites or, in the first
    // frame, what it writes.
    void KeepInstances() {
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
            [copies, &history = m_history, isStill = m_isStill,
             changeFrames = m_changeFrames > 0 ? m_changeFrames - 1 : 0,
             frame = RealTimeHistory::Frame{m_settings.extent, m_camera, EyeOf(m_settings.camera)}](
                CommandList& commands, const PassResources& resources) {
                for (const Copy& copy : copies)
                    commands.CopyBuffer(resources.Buffer(copy.from), 0, resources.Buffer(copy.to), 0,
                                        copy.bytes);
                commands.OnSubmitted([&history, isStill, frame, changeFrames] {
                    history.m_before = frame;
                    history.m_isOdd = !history.m_isOdd;
                    history.m_change = Change::None;
                    history.m_changeFrames = changeFrames;
                    ++history.m_frameCount;
                    history.m_stillFrames = isStill ? history.m_stillFrames + 1 : 0;
                });
            });
    }

    Renderer& m_renderer;
    const SceneIds& m_scene;
    const TraceSettings& m_settings;
    RealTimeHistory& m_history;
    const RealTimeSettings& m_realTime;
    gpu::CameraRecord m_camera;
    bool m_hasHistory = false;
    bool m_hasChanged = false;    // something else than the camera's place and field of view
    uint32_t m_changeFrames = 0;  // for which light is compared, from this one on
    bool m_hasInstances = false;
    bool m_isStill = false;  // nothing has changed since the frame before
    BufferId m_instances, m_deformed;
    Textures m_before, m_now;
};

TextureId RealTime(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, TextureId sample,
                   RealTimeHistory& history, const RealTimeSettings& realTime) {
    return RealTimeFrame(renderer, scene, settings, history, realTime).Declare(sample);
}

TextureId LastRealTime(Renderer& renderer, const RealTimeHistory& history, Extent2D extent) {
    return renderer.Persist(history.NameOf("picture", false), {extent, kColors});
}

TextureId HandOver(Renderer& renderer, TextureId picture, const AccumulatedIds& samples,
                   const Accumulation::Progress& progress) {
    const Extent2D extent = ExtentOfAll(renderer, {picture, samples.mean});
    const Extent2D blocks = BlocksOf(extent, gpu::kHandOverBlock);
    const struct {
        uint32_t sampleCount, doneRows, doneColumns, bandHeight;
    } constants{progress.sampleCount, progress.cursor.Y(), progress.cursor.X(), progress.cursor.BandHeight()};
    TextureId weights = renderer.CreateTexture("handOverWeights", {blocks, Format::R32Float});
    AddCompute(renderer, "HandOverWeights", "real_time/hand_over_weights.comp", blocks,
               [&](PassBuilder& pass) {
                   pass.Reads("picture", picture);
                   ReadSums(pass, samples, true);
                   pass.Constants(constants);
                   weights = pass.Writes("weights", weights);
               });
    TextureId shown = renderer.CreateTexture("handedOver", {extent, Format::Rgba32Float});
    AddCompute(renderer, "HandOver", "real_time/hand_over.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("picture", picture);
        pass.Reads("reference", samples.mean);
        pass.Reads("weights", weights);
        pass.Constants(constants);
        shown = pass.Writes("shown", shown);
    });
    return shown;
}

void Release(Renderer& renderer, RealTimeHistory& history) {
    for (const char* part : {"instances", "deformed"}) renderer.Release(history.Name() + "." + part);
    for (const char* part : {"surfaces", "mean", "deviation", "picture"})
        for (const bool isNext : {false, true}) renderer.Release(history.NameOf(part, isNext));
    history = RealTimeHistory(history.Name());
}

}  // namespace raygraph::passes
