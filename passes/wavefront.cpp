#include "passes/wavefront.h"

#include <algorithm>
#include <cstdlib>
#include <string>

#include "passes/scene_bindings.h"
#include "shaders/shared/wavefront.h"

namespace raygraph::passes {

namespace {

struct Wave {
    uint32_t step, pixelCount, width, isProbedOnce;
};

uint32_t Steps() {
    const char* text = std::getenv("RAYGRAPH_WAVE_STEPS");
    return text != nullptr ? static_cast<uint32_t>(std::atoi(text)) : 4;
}

struct WaveIds {
    TextureId radiance;
    BufferId paths, hits, shadows, queue, counts, media, pixelQueue;
};

class Wavefront {
  public:
    Wavefront(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, BufferId counts)
        : m_renderer(renderer), m_scene(scene), m_settings(settings), m_extent(RegionOf(settings).Extent()) {
        const uint64_t pixels = uint64_t{m_extent.width} * m_extent.height;
        m_pixels = static_cast<uint32_t>(pixels);
        m_ids.radiance = renderer.CreateTexture("radiance", {m_extent, Format::Rgba32Float});
        m_ids.pixelQueue = counts;
        m_ids.paths = renderer.CreateBuffer("wavePaths", {.size = pixels * 16 * gpu::kWavePathRows});
        m_ids.hits = renderer.CreateBuffer("waveHits", {.size = (pixels + (pixels + 3) / 4) * 16});
        m_ids.shadows = renderer.CreateBuffer("waveShadows", {.size = pixels * 16 * gpu::kWaveShadowRows});
        m_ids.queue = renderer.CreateBuffer("waveQueue", {.size = pixels * 8});
        m_ids.media = renderer.CreateBuffer("waveMedia", {.size = scene.hasVolumes ? (pixels + 1) * 32 : 32});
        m_ids.counts = renderer.CreateBuffer("waveCounts", {.size = 4 * (2 * Steps() + 2)});
        renderer.AddPass(
            "WaveCounts", PassKind::Transfer, [&](PassBuilder& pass) { m_ids.counts = pass.CopiesTo(m_ids.counts); },
            [id = m_ids.counts](CommandList& commands, const PassResources& resources) {
                commands.Fill(resources.Buffer(id), 0);
            });
    }

    TraceIds Declare() {
        const uint32_t steps = Steps();
        First();
        for (uint32_t step = 0; step < steps; ++step) {
            if (step > 0) Extend(step);
            Shade(step);
            if (m_scene.lightSet.activeCount > 0 && m_settings.lights.isOn) Shadow(step);
        }
        Rest(steps);
        Finish();
        return {.radiance = m_ids.radiance, .counts = m_ids.pixelQueue};
    }

  private:
    Wave At(uint32_t step) const { return {step, m_pixels, m_extent.width, IsPinhole() ? 1u : 0u}; }
    bool IsPinhole() const { return m_settings.camera.lensRadius == 0.0f && m_settings.camera.orthographic == 0u; }
    void Tracing(PassBuilder& pass) {
        SpecializeTrace(pass, m_scene, m_settings);
        BindTracing(pass, m_scene, ParametersFor(m_scene, m_settings), AlphaTest::On);
        BindGeometry(pass, m_scene);
        BindMaterials(pass, m_scene);
    }
    // Invocations take one path after the other.
    Extent2D LaunchOf(uint32_t step) const {
        const uint32_t width = std::max(m_pixels >> std::min(step, 4u), std::min(m_pixels, 1u << 16));
        return {width, 1};
    }
    auto TracesAll(uint32_t step) const {
        return [extent = LaunchOf(step)](CommandList& commands) { commands.TraceRays(extent); };
    }

    void First() {
        m_renderer.AddPass(
            "WaveFirst", PassKind::RayTracing,
            [&](PassBuilder& pass) {
                pass.RayGen("pathtrace/wave_first.rgen");
                Tracing(pass);
                pass.Constants(At(0));
                m_ids.hits = pass.Writes("waveHits", m_ids.hits);
                m_ids.media = pass.Writes("waveMedia", m_ids.media);
            },
            TracesAll(0));
    }
    void Extend(uint32_t step) {
        m_renderer.AddPass(
            "WaveExtend" + std::to_string(step), PassKind::RayTracing,
            [&](PassBuilder& pass) {
                pass.RayGen("pathtrace/wave_extend.rgen");
                Tracing(pass);
                pass.Constants(At(step));
                m_ids.counts = pass.Updates("waveCounts", m_ids.counts);
                m_ids.queue = pass.Updates("waveQueue", m_ids.queue);
                m_ids.paths = pass.Updates("wavePaths", m_ids.paths);
                m_ids.hits = pass.Writes("waveHits", m_ids.hits);
            },
            TracesAll(step));
    }
    void Shade(uint32_t step) {
        m_renderer.AddPass(
            "WaveShade" + std::to_string(step), PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("pathtrace/wave_shade.comp");
                SpecializeTrace(pass, m_scene, m_settings);
                pass.Uniform("parameters", ParametersFor(m_scene, m_settings));
                BindGeometry(pass, m_scene);
                BindMaterials(pass, m_scene);
                BindEnvironment(pass, m_scene);
                BindLights(pass, m_scene);
                pass.Reads("energyTables", m_scene.energyTables);
                pass.Constants(At(step));
                m_ids.hits = pass.Updates("waveHits", m_ids.hits);
                m_ids.counts = pass.Updates("waveCounts", m_ids.counts);
                m_ids.queue = step == 0 ? pass.Writes("waveQueue", m_ids.queue) : pass.Updates("waveQueue", m_ids.queue);
                m_ids.paths = step == 0 ? pass.Writes("wavePaths", m_ids.paths) : pass.Updates("wavePaths", m_ids.paths);
                m_ids.media = pass.Updates("waveMedia", m_ids.media);
                m_ids.shadows = pass.Writes("waveShadows", m_ids.shadows);
                m_ids.radiance = step == 0 ? pass.Writes("radiance", m_ids.radiance) : pass.Updates("radiance", m_ids.radiance);
            },
            [extent = LaunchOf(step)](CommandList& commands) { commands.DispatchOver(extent); });
    }
    void Shadow(uint32_t step) {
        m_renderer.AddPass(
            "WaveShadow" + std::to_string(step), PassKind::RayTracing,
            [&](PassBuilder& pass) {
                pass.RayGen("pathtrace/wave_shadow.rgen");
                Tracing(pass);
                BindShadowRays(pass, m_scene);
                pass.Constants(At(step));
                m_ids.counts = pass.Updates("waveCounts", m_ids.counts);
                m_ids.shadows = pass.Updates("waveShadows", m_ids.shadows);
                m_ids.radiance = pass.Updates("radiance", m_ids.radiance);
            },
            TracesAll(step));
    }
    void Rest(uint32_t step) {
        m_renderer.AddPass(
            "WaveRest", PassKind::RayTracing,
            [&](PassBuilder& pass) {
                pass.RayGen("pathtrace/wave_rest.rgen");
                Tracing(pass);
                BindShadowRays(pass, m_scene);
                BindEnvironment(pass, m_scene);
                BindLights(pass, m_scene);
                pass.Reads("energyTables", m_scene.energyTables);
                pass.Constants(At(step));
                m_ids.counts = pass.Updates("waveCounts", m_ids.counts);
                m_ids.queue = pass.Updates("waveQueue", m_ids.queue);
                m_ids.paths = pass.Updates("wavePaths", m_ids.paths);
                m_ids.media = pass.Updates("waveMedia", m_ids.media);
                m_ids.pixelQueue = pass.Updates("pixelQueue", m_ids.pixelQueue);
                m_ids.radiance = pass.Updates("radiance", m_ids.radiance);
            },
            [extent = Extent2D{std::min(m_pixels, 1u << 16), 1}](CommandList& commands) { commands.TraceRays(extent); });
    }
    void Finish() {
        m_renderer.AddPass(
            "WaveFinish", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("pathtrace/wave_finish.comp");
                m_ids.pixelQueue = pass.Updates("pixelQueue", m_ids.pixelQueue);
                m_ids.radiance = pass.Updates("radiance", m_ids.radiance);
            },
            [extent = m_extent](CommandList& commands) { commands.DispatchOver(extent); });
    }

    Renderer& m_renderer;
    const SceneIds& m_scene;
    const TraceSettings& m_settings;
    Extent2D m_extent;
    uint32_t m_pixels = 0;
    WaveIds m_ids;
};

}  // namespace

bool HasWavefront(const SceneIds& scene, const TraceSettings& settings, const TraceOutputs& outputs) {
    return !outputs.rayCounts && !outputs.parts && !outputs.lightGroups &&
           (LobeFeatures(scene, settings) & kTraceMatchedMedia) == 0;
}

TraceIds TraceWavefront(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                        BufferId counts) {
    return Wavefront(renderer, scene, settings, counts).Declare();
}

}  // namespace raygraph::passes
