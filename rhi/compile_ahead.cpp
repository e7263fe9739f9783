#include "rhi/compile_ahead.h"

#include <cstring>
#include <exception>

#include "base/log.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/shader_compiler.h"

namespace raygraph::rhi {

namespace {

// The number of the first shader group that is created on a device.
constexpr uint32_t kFirstNumber = 2;

// Returns the number of the pipeline's first group on its device, which this driver stores in the handle.
uint32_t FirstGroup(const Device& device, const RayTracingPipeline& pipeline) {
    std::vector<std::byte> handle(device.Info().shaderGroupHandleSize);
    device.Check(device.Vk().vkGetRayTracingShaderGroupHandlesKHR(device.Handle(), pipeline.Handle(), 0, 1,
                                                                  handle.size(), handle.data()),
                 pipeline.Name() + ": vkGetRayTracingShaderGroupHandlesKHR");
    uint32_t number = 0;
    std::memcpy(&number, handle.data(), sizeof number);
    return number;
}

// Creates `count` shader groups, at least 1: ray generation is one, each miss another.
void SkipGroups(Device& device, uint32_t count) {
    const auto compile = [](StageKind stage) {
        return CompileGlsl({.name = "nothing",
                            .text = "#version 460\n#extension GL_EXT_ray_tracing : require\nvoid main() {}\n",
                            .stage = stage});
    };
    const std::vector<uint32_t> rayGen = compile(StageKind::RayGen), miss = compile(StageKind::Miss);
    RayTracingPipelineDesc desc{.name = "skipped groups"};
    desc.rayGen.stage = {.name = "nothing.rgen", .spirv = rayGen};
    desc.miss.resize(count - 1, {.stage = {.name = "nothing.rmiss", .spirv = miss}, .recordData = {}});
    static_cast<void>(CreateRayTracingPipeline(device, desc));
}

// Executes no invocation, so that nothing is read: unlike others, this driver needs no bound resources for
// that.
void Execute(Device& device, const RayTracingPipeline& pipeline) {
    CommandList commands = device.BeginCommands("compile ahead");
    const DeviceFunctions& vk = device.Vk();
    vk.vkCmdBindPipeline(commands.Handle(), VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, pipeline.Handle());
    vk.vkCmdTraceRaysKHR(commands.Handle(), &pipeline.RayGenRegion(), &pipeline.MissRegion(),
                         &pipeline.HitRegion(), &pipeline.CallableRegion(), 0, 1, 1);
    device.WaitFor(device.Submit(std::move(commands)));
}

void Execute(Device& device, const ComputePipeline& pipeline) {
    CommandList commands = device.BeginCommands("compile ahead");
    const DeviceFunctions& vk = device.Vk();
    vk.vkCmdBindPipeline(commands.Handle(), VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.Handle());
    vk.vkCmdDispatch(commands.Handle(), 0, 1, 1);
    device.WaitFor(device.Submit(std::move(commands)));
}

// Calls `run` with the second device; it returns a message if the device is not suitable, or "".
template <typename Run>
void OnSecondDevice(const Device& device, const Pipeline& made, Run&& run) {
    if (!device.Info().isLavapipe) return;
    const Stopwatch watch;
    const auto say = [&](std::string_view outcome) {
        WriteLog(device.Log(), LogLevel::Debug, log_category::kShaders, "{}: {}", made.Name(), outcome);
    };
    try {
        const std::unique_ptr<Device> ahead = Device::Create(
            {.name = "compile ahead", .select = device.Info().name, .savePipelineCache = false});
        if (!ahead->Info().isLavapipe) return say("no second device to compile ahead on");
        const std::string problem = run(*ahead);
        say(problem.empty() ? "compiled ahead in " + DurationText(watch.Seconds()) : problem);
    } catch (const std::exception& error) {
        say(Text("the first frame compiles it: {}", error.what()));
    }
}

}  // namespace

void CompileAhead(const Device& device, const RayTracingPipelineDesc& desc, const RayTracingPipeline& made) {
    OnSecondDevice(device, made, [&](Device& ahead) -> std::string {
        const uint32_t first = FirstGroup(device, made);
        if (first > kFirstNumber) SkipGroups(ahead, first - kFirstNumber);
        const RayTracingPipeline same = CreateRayTracingPipeline(ahead, desc);
        if (FirstGroup(ahead, same) != first) return "the second device counts groups otherwise";
        Execute(ahead, same);
        return "";
    });
}

void CompileAhead(const Device& device, const ComputePipelineDesc& desc, const ComputePipeline& made) {
    OnSecondDevice(device, made, [&](Device& ahead) -> std::string {
        Execute(ahead, CreateComputePipeline(ahead, desc));
        return "";
    });
}

}  // namespace raygraph::rhi
