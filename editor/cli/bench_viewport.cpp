#include "editor/cli/bench_viewport.h"

#include <array>
#include <functional>
#include <tuple>

#include "base/median.h"
#include "base/os.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/viewport/viewport.h"
#include "passes/accumulate.h"

namespace raygraph::cli {

using namespace session;  // NOLINT

namespace {

// Runs frames that trace samples; each call returns how many it has traced, when the device is idle.
class SampleSource {
  public:
    virtual ~SampleSource() = default;
    virtual Renderer& GraphRenderer() = 0;
    virtual double RunFrame() = 0;
};

class RenderSource : public SampleSource {
  public:
    RenderSource(DeviceScene& scene, uint32_t samples) : m_scene(scene), m_samples(samples) {}
    Renderer& GraphRenderer() override { return m_scene.GraphRenderer(); }
    double RunFrame() override {
        Renderer& renderer = m_scene.GraphRenderer();
        renderer.BeginFrame();
        const SceneIds ids = m_scene.Declare(m_next);
        passes::TraceSettings settings = m_scene.SettingsFor(m_next);
        settings.sampleCount = m_samples;
        const TextureId traced = passes::Trace(renderer, ids, settings).radiance;
        // No mean and no variance, as in all frames of a render but the last one
        renderer.Present(
            passes::Accumulate(renderer, traced, {.count = m_samples}, m_accumulation, true).sums[0]);
        renderer.Device().WaitFor(renderer.Execute());
        m_next += m_samples;
        return m_samples;
    }

  private:
    DeviceScene& m_scene;
    uint32_t m_samples, m_next = 0;
    passes::Accumulation m_accumulation{"bench render"};
};

class ViewportSource : public SampleSource {
  public:
    ViewportSource(Renderer& renderer, GpuScene& scene, const PictureSettings& settings,
                   const scene::CameraView& camera, const char* name, double budgetMs)
        : m_renderer(renderer), m_viewport(renderer, scene, {.name = name, .size = settings.size}) {
        m_viewport.SetPaths(settings.paths);
        m_viewport.SetCamera(camera);
        m_viewport.SetBudget({.frameMs = budgetMs});
    }
    Renderer& GraphRenderer() override { return m_renderer; }
    double RunFrame() override {
        const double before = Samples();
        m_renderer.Device().WaitFor(m_viewport.RenderFrame());
        return Samples() - before;
    }

  private:
    double Samples() const {
        const viewport::ViewportProgress progress = m_viewport.Progress();
        return progress.pathTracedSamples + progress.pathTracedFraction;
    }
    Renderer& m_renderer;
    viewport::Viewport m_viewport;
};

struct Total {
    double samples = 0.0, frames = 0.0, cpuSeconds = 0.0, gpuMs = 0.0, wallMs = 0.0;
};

// Runs until at least so many more samples are traced.
Total Run(SampleSource& source, uint32_t samples) {
    std::ignore = source.GraphRenderer().TakeTimings();
    Total total;
    const Stopwatch watch;
    const double before = os::ProcessCpuSeconds();
    while (total.samples < samples) {
        total.samples += source.RunFrame();
        ++total.frames;
    }
    total.cpuSeconds = os::ProcessCpuSeconds() - before;
    total.wallMs = watch.Milliseconds();
    for (const FrameTiming& frame : source.GraphRenderer().TakeTimings())
        for (const PassTiming& pass : frame.passes) total.gpuMs += pass.gpuMs;
    return total;
}

}  // namespace

ViewportCosts BenchViewport(DeviceScene& render, scene::SceneData&& data, const PictureSettings& settings,
                            const BenchPlan& plan, const RelativeCost& cost, double budgetMs,
                            Progress& progress) {
    rhi::Device& device = render.GraphRenderer().Device();
    const float aspect = static_cast<float>(settings.size.width) / static_cast<float>(settings.size.height);
    const scene::CameraView camera = scene::ChooseView(data, settings.camera, aspect);
    Renderer renderer(device);
    GpuScene scene(renderer);
    scene.SetScene(std::move(data));
    const uint32_t atOnce =
        plan.batchSize > 0 ? plan.batchSize : passes::PreferredBatchSize(device, render.SettingsFor(0));
    RenderSource ofRender(render, atOnce);
    ViewportSource oneSamplePerFrame(renderer, scene, settings, camera, "one a frame", 0.0);
    ViewportSource withinBudget(renderer, scene, settings, camera, "within budget", budgetMs);
    const std::array<SampleSource*, 3> sources{&ofRender, &oneSamplePerFrame, &withinBudget};
    progress.ShowStep("warming up");
    constexpr uint32_t kWarmUpSamples = 3;
    for (SampleSource* source : sources) std::ignore = Run(*source, kWarmUpSamples);

    const bool isCpu = device.Info().type == rhi::DeviceType::Cpu;
    std::array<Total, 3> totals;
    std::array<std::vector<double>, 3> ratios;
    for (uint32_t round = 0; round < plan.rounds; ++round) {
        progress.ShowStep(Text("round {}/{}", round + 1, plan.rounds));
        double ofOne = 0.0;
        for (size_t i = 0; i < sources.size(); ++i) {
            const Total total = Run(*sources[i], plan.frames);
            const double perSample = (isCpu ? total.cpuSeconds : total.gpuMs) / total.samples;
            if (i == 0) ofOne = perSample;
            ratios[i].push_back(ofOne > 0.0 ? perSample / ofOne : 0.0);
            totals[i].samples += total.samples;
            totals[i].frames += total.frames;
            totals[i].cpuSeconds += total.cpuSeconds;
            totals[i].gpuMs += total.gpuMs;
            totals[i].wallMs += total.wallMs;
        }
    }
    const auto costOf = [&](size_t i) {
        const Total& total = totals[i];
        std::vector<double> costs = ratios[i];
        for (double& ratio : costs) ratio *= cost.median;
        return SampleCost{.cpuSeconds = total.cpuSeconds / total.samples,
                          .gpuMs = total.gpuMs / total.samples,
                          .wallMs = total.wallMs / total.samples,
                          .samplesPerFrame = total.samples / total.frames,
                          .relative = Median(ratios[i]),
                          .cost = RelativeCostOf(cost.measure, costs)};
    };
    return {
        .budgetMs = budgetMs, .render = costOf(0), .oneSamplePerFrame = costOf(1), .withinBudget = costOf(2)};
}

}  // namespace raygraph::cli
