// Implements `raygraph graph`.
#include <string>

#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/session/frames/device_scene.h"
#include "passes/accumulate.h"
#include "passes/tonemap.h"
#include "renderer/graph/plan_text.h"

namespace raygraph::cli {

namespace {

// Compaction is polled once a frame; a scene that has not settled after this many is shown as it is.
constexpr uint32_t kMaxFramesToSettle = 64;

// Declares the frame in which `render` traces its last sample: the picture, its variance and its display.
void DeclareSample(DeviceScene& scene, passes::Accumulation& accumulation, uint32_t sampleIndex) {
    Renderer& renderer = scene.GraphRenderer();
    renderer.BeginFrame();
    const SceneIds ids = scene.Declare(sampleIndex);
    const TextureId sample = passes::Trace(renderer, ids, scene.SettingsFor(sampleIndex)).radiance;
    const passes::AccumulatedIds sums = passes::Accumulate(renderer, sample, accumulation, true);
    renderer.Present(passes::Tonemap(renderer, sums.mean));
}

}  // namespace

void GraphCommand(const GraphArguments& arguments, Console& console) {
    const PictureSettings settings = SettingsFrom(arguments.given);
    const Log log = console.log.ForLibraries();
    InputOptions options = InputOptionsFor(settings);
    options.root = arguments.root;
    options.log = log;
    SceneInput input = LoadInput(arguments.scene, options);
    const std::unique_ptr<rhi::Device> device = OpenDevice({.select = arguments.device}, log);
    DeviceScene scene(*device, input, settings);
    Renderer& renderer = scene.GraphRenderer();
    passes::Accumulation accumulation("radiance");
    uint32_t frame = 0;
    if (!arguments.isFirstFrame) {
        do {
            DeclareSample(scene, accumulation, frame++);
            device->WaitFor(renderer.Execute());
        } while (!scene.Scene().IsSettled() && frame < kMaxFramesToSettle);
    }
    DeclareSample(scene, accumulation, frame);
    renderer.Compile();
    const auto& [graph, compiled] = renderer.LastCompiled();
    const std::string plan = arguments.isJson  ? DescribePlanJson(graph, compiled)
                             : arguments.isDot ? DescribePlanDot(graph, compiled)
                                               : DescribePlan(graph, compiled);
    std::fputs(plan.c_str(), stdout);
    if (!plan.ends_with('\n')) std::fputc('\n', stdout);
}

}  // namespace raygraph::cli
