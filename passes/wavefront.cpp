#include "passes/wavefront.h"

#include <algorithm>
#include <string>

#include "passes/add_compute.h"
#include "passes/scene_bindings.h"
#include "shaders/shared/wavefront.h"

namespace raygraph::passes {

namespace {

constexpr auto kPathPartNames = Texts(PathPart{});
constexpr uint32_t kRowBytes = 16;
constexpr uint32_t kGroupSize = 64;  // group size in pathtrace/wave_shade_main.glsl and launch.glsl
// After this many rays of each path, the loop goes on with the paths that are left: among the best of 2, 4, 8
// and 16 in all scenes of docs/performance.md.
constexpr uint32_t kSteps = 8;
// The number of paths that the last kernel traces at once, of those that are left for it.
constexpr uint32_t kInvocationsOfRest = 1u << 16;

// Holds the number of rows of the records of a picture.
struct RecordRows {
    TraceFeatures features;
    bool hasParts;

    // These two are the conditions of rows.
    bool HasTraceFeature(TraceFeatures any) const { return features.Has(any); }
    bool KeepsParts() const { return hasParts; }

    uint32_t OfPath() const { return 0u RAYGRAPH_WAVE_PATH_ROWS(RAYGRAPH_WAVE_COUNT_ROW); }
    uint32_t OfShadow() const { return 0u RAYGRAPH_WAVE_SHADOW_ROWS(RAYGRAPH_WAVE_COUNT_ROW); }
};

class Wavefront {
  public:
    Wavefront(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
              const TraceOutputs& outputs, const TraceIds& ids)
        : m_renderer(renderer),
          m_scene(scene),
          m_settings(settings),
          m_outputs(outputs),
          m_features(ProgramFeatures(scene, settings)),
          m_rows{m_features, outputs.parts},
          m_isSoftware(UsesSoftwareTraversal(scene, settings)),
          m_extent(renderer.Desc(ids.radiance).extent),
          m_ids(ids) {
        const uint64_t pixels = uint64_t{m_extent.width} * m_extent.height;
        m_pixels = static_cast<uint32_t>(pixels);
        const auto buffer = [&](const char* name, uint64_t size) {
            return renderer.CreateBuffer(name, {.size = size});
        };
        // One record more holds the media around the camera
        m_paths = buffer("wavePaths", (pixels + 1) * m_rows.OfPath() * kRowBytes);
        m_hits = buffer("waveHits", (pixels + (pixels + 3) / 4) * kRowBytes);
        m_shadows = buffer("waveShadows", pixels * m_rows.OfShadow() * kRowBytes);
        m_queue = buffer("waveQueue", pixels * 2 * sizeof(uint32_t));
        m_counts = buffer("waveCounts", (kSteps + 1) * 2 * sizeof(uint32_t));
    }

    TraceIds Declare() {
        const bool hasLights = m_features.Has(kTraceLightSampling);
        // Shadow rays that may take several rays come first: the next ray's number depends on how many
        const bool isApart = m_features.Has(kTraceMatchedMedia);
        ClearCounts();
        TraceFirst();
        for (uint32_t step = 0; step < kSteps; ++step) {
            if (step > 0) {
                if (hasLights && isApart) Trace(step, gpu::kWaveTracesShadows);
                Trace(step, gpu::kWaveTracesPaths | (hasLights && !isApart ? gpu::kWaveTracesShadows : 0u));
            }
            Shade(step);
        }
        if (hasLights) Trace(kSteps, gpu::kWaveTracesShadows);
        TraceRest();
        Finish();
        return m_ids;
    }

  private:
    // Returns, for example, "pathtrace/wave_shade_parts".
    std::string Shader(const char* kernel) const {
        return std::string("pathtrace/wave_") + kernel + (m_outputs.parts ? "_parts" : "") +
               (m_outputs.lightGroups ? "_groups" : "");
    }
    // Paths become fewer with every step, and an invocation takes one after the other.
    Extent2D LaunchAt(uint32_t step) const {
        constexpr uint32_t kLeast = 1u << 16, kMostHalvings = 4;
        return {std::max(m_pixels >> std::min(step, kMostHalvings), std::min(m_pixels, kLeast)), 1};
    }
    // Clamps a launch to the groups that the device has.
    Extent2D Dispatched(Extent2D launch) const {
        const uint64_t most = uint64_t{m_renderer.Device().Info().maxGroupCounts[0]} * kGroupSize;
        return {static_cast<uint32_t>(std::min<uint64_t>(launch.width, most)), 1};
    }
    // Returns the kind of the kernels that trace.
    PassKind TracingKind() const { return m_isSoftware ? PassKind::Compute : PassKind::RayTracing; }
    void UseTracing(PassBuilder& pass, const std::string& kernel) const {
        if (m_isSoftware)
            pass.Compute(kernel + ".comp");
        else
            pass.RayGen(kernel + ".rgen");
    }
    auto Launching(Extent2D launch) const {
        return [extent = m_isSoftware ? Dispatched(launch) : launch,
                isSoftware = m_isSoftware](CommandList& commands) {
            if (isSoftware)
                commands.DispatchOver(extent);
            else
                commands.TraceRays(extent);
        };
    }
    static std::string At(const char* name, uint32_t step) { return name + std::to_string(step); }

    void BindScene(PassBuilder& pass) const {
        SpecializeTrace(pass, m_scene, m_settings);
        BindGeometry(pass, m_scene);
        BindMaterials(pass, m_scene);
    }
    void BindLighting(PassBuilder& pass) const {
        BindEnvironment(pass, m_scene);
        BindLights(pass, m_scene);
        pass.Reads("energyTables", m_scene.energyTables);
    }
    void BindRays(PassBuilder& pass, bool bindsShadowRays) const {
        const gpu::TraceParameters parameters = ParametersFor(m_scene, m_settings);
        if (m_isSoftware) return BindSoftwareTracing(pass, m_scene, parameters);
        BindTracing(pass, m_scene, parameters, AlphaTest::On);
        if (bindsShadowRays) BindShadowRays(pass, m_scene);
    }
    void SetConstants(PassBuilder& pass, uint32_t step, uint32_t traces = 0) const {
        const gpu::CameraRecord& camera = m_settings.camera;
        const bool isPinhole = camera.lensRadius == 0.0f && camera.orthographic == 0u;
        pass.Constants(gpu::WaveConstants{.size = {m_extent.width, m_extent.height},
                                          .step = step,
                                          .pathRows = m_rows.OfPath(),
                                          .isProbedOnce = isPinhole ? 1u : 0u,
                                          .traces = traces,
                                          .firstPaths = static_cast<uint32_t>(PathCount(m_settings))});
    }
    // Binds all outputs of a sample; `isFirst` says that they have no contents yet.
    void BindOutputs(PassBuilder& pass, bool isFirst) {
        const auto bind = [&](const char* name, TextureId& id) {
            id = isFirst ? pass.Writes(name, id) : pass.Updates(name, id);
        };
        bind("radiance", m_ids.radiance);
        for (size_t i = 0; m_outputs.parts && i < kPathPartCount; ++i)
            bind(kPathPartNames[i], m_ids.parts[i]);
        if (m_outputs.lightGroups) bind("lightGroups", m_ids.lightGroups);
    }

    void ClearCounts() {
        m_renderer.AddPass(
            "WaveCounts", PassKind::Transfer, [&](PassBuilder& pass) { m_counts = pass.CopiesTo(m_counts); },
            [id = m_counts](CommandList& commands, const PassResources& resources) {
                commands.Fill(resources.Buffer(id), 0);
            });
    }

    void TraceFirst() {
        m_renderer.AddPass(
            "WaveFirst", TracingKind(),
            [&](PassBuilder& pass) {
                UseTracing(pass, "pathtrace/wave_first");
                BindScene(pass);
                BindRays(pass, false);
                SetConstants(pass, 0);
                m_paths = pass.Writes("wavePaths", m_paths);
                m_hits = pass.Writes("waveHits", m_hits);
            },
            Launching(LaunchAt(0)));
    }

    void Trace(uint32_t step, uint32_t traces) {
        const char* name = traces == gpu::kWaveTracesShadows ? "WaveShadows" : "WaveTrace";
        m_renderer.AddPass(
            At(name, step), TracingKind(),
            [&](PassBuilder& pass) {
                UseTracing(pass, Shader("trace"));
                BindScene(pass);
                BindRays(pass, true);
                if (m_outputs.lightGroups) BindLights(pass, m_scene);
                pass.Reads("energyTables",
                           m_scene.energyTables);  // for walls that light passes straight through
                SetConstants(pass, step, traces);
                pass.Reads("waveCounts", m_counts);
                pass.Reads("waveQueue", m_queue);
                pass.Reads("waveShadows", m_shadows);
                m_paths = pass.Updates("wavePaths", m_paths);
                m_hits = pass.Updates("waveHits", m_hits);
                m_ids.counts = pass.Updates("pixelQueue", m_ids.counts);
                BindOutputs(pass, false);
            },
            Launching(LaunchAt(step)));
    }

    void Shade(uint32_t step) {
        m_renderer.AddPass(
            At("WaveShade", step), PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute(Shader("shade") + ".comp");
                BindScene(pass);
                BindLighting(pass);
                pass.Uniform("parameters", ParametersFor(m_scene, m_settings));
                SetConstants(pass, step);
                pass.Reads("waveHits", m_hits);
                m_paths = pass.Updates("wavePaths", m_paths);
                m_counts = pass.Updates("waveCounts", m_counts);
                m_queue = step == 0 ? pass.Writes("waveQueue", m_queue) : pass.Updates("waveQueue", m_queue);
                m_shadows = pass.Writes("waveShadows", m_shadows);
                BindOutputs(pass, step == 0);
            },
            [extent = Dispatched(LaunchAt(step))](CommandList& commands) { commands.DispatchOver(extent); });
    }

    void TraceRest() {
        m_renderer.AddPass(
            "WaveRest", TracingKind(),
            [&](PassBuilder& pass) {
                UseTracing(pass, Shader("rest"));
                BindScene(pass);
                BindLighting(pass);
                BindRays(pass, false);
                BindLoopRays(pass, m_renderer.Device(), m_scene, m_settings);
                SetConstants(pass, kSteps);
                pass.Reads("waveCounts", m_counts);
                pass.Reads("waveQueue", m_queue);
                pass.Reads("wavePaths", m_paths);
                m_ids.counts = pass.Updates("pixelQueue", m_ids.counts);
                BindOutputs(pass, false);
            },
            Launching({std::min(m_pixels, kInvocationsOfRest), 1}));
    }

    void Finish() {
        AddCompute(m_renderer, "WaveFinish", Shader("finish") + ".comp", m_extent, [&](PassBuilder& pass) {
            SetConstants(pass, kSteps);
            pass.Reads("waveCounts", m_counts);
            m_ids.counts = pass.Updates("pixelQueue", m_ids.counts);
            BindOutputs(pass, false);
        });
    }

    Renderer& m_renderer;
    const SceneIds& m_scene;
    const TraceSettings& m_settings;
    TraceOutputs m_outputs;
    TraceFeatures m_features;
    RecordRows m_rows;
    bool m_isSoftware;  // kernels that trace are compute shaders
    Extent2D m_extent;
    uint32_t m_pixels = 0;
    TraceIds m_ids;
    BufferId m_paths, m_hits, m_shadows, m_queue, m_counts;
};

}  // namespace

TraceIds TraceWavefront(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                        const TraceOutputs& outputs, const TraceIds& ids) {
    return Wavefront(renderer, scene, settings, outputs, ids).Declare();
}

}  // namespace raygraph::passes
