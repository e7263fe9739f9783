// Measures what the graph costs the CPU: a three-pass frame like the path tracer's, and a longer one, on a
// picture of one texel so that the device has next to nothing to do.
#include <benchmark/benchmark.h>

#include "renderer/graph/compile.h"
#include "renderer/graph/plan_text.h"
#include "renderer/graph/renderer.h"
#include "rhi/shader_compiler.h"
#include "rhi/tlas.h"

namespace raygraph {
namespace {

std::vector<uint32_t> CompileText(std::string_view name, std::string_view text) {
    rhi::GlslSource source;
    source.name = name;
    source.text = "#version 460\n" + std::string(text);
    return rhi::CompileGlsl(source);
}

// Bindings as a path tracer has them: a structure, five buffers, a sampled texture, an image, uniform data,
// constants.
constexpr std::string_view kTraceShader = R"(
#extension GL_EXT_ray_tracing : require
layout(binding = 0) uniform accelerationStructureEXT sceneTlas;
layout(binding = 1, rgba32f) uniform writeonly image2D radiance;
layout(binding = 2, std430) readonly buffer Instances { vec4 instances[]; };
layout(binding = 3, std430) readonly buffer Geometries { vec4 geometries[]; };
layout(binding = 4, std430) readonly buffer Materials { vec4 materials[]; };
layout(binding = 5) uniform sampler2D environmentMap;
layout(binding = 6, std140) uniform Parameters { vec4 values[8]; } parameters;
layout(location = 0) rayPayloadEXT vec4 payload;
void main() {
    payload = instances[0] + geometries[0] + materials[0] + parameters.values[1] + texture(environmentMap, vec2(0.5));
    traceRayEXT(sceneTlas, 0u, 0xff, 0, 2, 0, vec3(0.0), 0.0, vec3(0.0, 0.0, 1.0), 1.0, 0);
    imageStore(radiance, ivec2(gl_LaunchIDEXT.xy), payload);
})";
constexpr std::string_view kMissShader = R"(
#extension GL_EXT_ray_tracing : require
layout(location = 0) rayPayloadInEXT vec4 payload;
void main() { payload += vec4(1.0); })";
constexpr std::string_view kAccumulateShader = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba32f) uniform readonly image2D newSample;
layout(binding = 1, rgba32f) uniform image2D mean;
layout(push_constant, std430) uniform Constants { uint count; } constants;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    vec4 before = imageLoad(mean, texel);
    imageStore(mean, texel, before + (imageLoad(newSample, texel) - before) / float(constants.count + 1));
})";
constexpr std::string_view kTonemapShader = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba32f) uniform readonly image2D source;
layout(binding = 1, rgba8) uniform writeonly image2D display;
layout(push_constant, std430) uniform Constants { vec2 exposure; } constants;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(display, texel, imageLoad(source, texel) * constants.exposure.x);
})";

struct Fixture {
    static constexpr Extent2D kExtent{1, 1};

    Fixture()
        : device(rhi::Device::Create({.savePipelineCache = false})),
          renderer(*device),
          tlas(*device, {.capacity = 1}) {
        renderer.AddShader("trace.rgen", CompileText("trace.rgen", kTraceShader));
        renderer.AddShader("miss.rmiss", CompileText("miss.rmiss", kMissShader));
        renderer.AddShader("accumulate.comp", CompileText("accumulate.comp", kAccumulateShader));
        renderer.AddShader("tonemap.comp", CompileText("tonemap.comp", kTonemapShader));
        for (rhi::Buffer& buffer : buffers) buffer = device->CreateBuffer({.name = "records", .size = 1024});
        environment =
            device->CreateTexture({.name = "environment",
                                   .extent = kExtent,
                                   .usage = rhi::TextureUsage::Sampled | rhi::TextureUsage::CopyDestination});
        rhi::CommandList commands = device->BeginCommands("set up");
        commands.Transition(environment, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
        environmentState.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
        const rhi::Buffer instances = device->CreateBuffer(
            {.name = "instances", .size = rhi::kTlasInstanceBytes, .usage = rhi::BufferUsage::BuildInput});
        tlas.Build(commands, instances, 0);
        device->Submit(std::move(commands));
        device->WaitIdle();
    }

    TextureId Trace() {
        TextureId radiance = renderer.CreateTexture("radiance", {.extent = kExtent});
        const TlasId sceneTlas = renderer.Import("sceneTlas", tlas, tlasState);
        const BufferId records[] = {renderer.Import("instances", buffers[0], bufferStates[0]),
                                    renderer.Import("geometries", buffers[1], bufferStates[1]),
                                    renderer.Import("materials", buffers[2], bufferStates[2]),
                                    renderer.Import("vertexData", buffers[3], bufferStates[3])};
        const BlasSetId blases = renderer.ImportBlasSet("blases", blasState);
        const TextureId map = renderer.Import("environmentMap", environment, environmentState);
        renderer.AddPass(
            "Trace", PassKind::RayTracing,
            [&](PassBuilder& pass) {
                pass.RayGen("trace.rgen").Miss(RayType::Radiance, "miss.rmiss");
                pass.Reads("sceneTlas", sceneTlas);
                pass.ReadsByAddress(blases);
                pass.Reads("Instances", records[0]);
                pass.Reads("Geometries", records[1]);
                pass.Reads("Materials", records[2]);
                pass.ReadsByAddress(records[3]);
                pass.Reads("environmentMap", map, rhi::SamplerDesc{});
                pass.Uniform("parameters", parameters);
                radiance = pass.Writes("radiance", radiance);
            },
            [](CommandList& commands) { commands.TraceRays(kExtent); });
        return radiance;
    }
    TextureId Accumulate(std::string_view name, TextureId sample) {
        TextureId mean = renderer.Persist(name, {.extent = kExtent});
        renderer.AddPass(
            "Accumulate", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("accumulate.comp");
                pass.Reads("newSample", sample);
                mean = pass.Updates("mean", mean);
                pass.Constants(count);
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
        return mean;
    }
    TextureId Tonemap(TextureId source) {
        TextureId display =
            renderer.CreateTexture("display", {.extent = kExtent, .format = Format::Rgba8Unorm});
        renderer.AddPass(
            "Tonemap", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("tonemap.comp");
                pass.Reads("source", source);
                display = pass.Writes("display", display);
                pass.Constants(std::array{1.0f, 0.0f});
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
        return display;
    }
    // Trace, then accumulations, then Tonemap.
    void DeclareFrame(int accumulations) {
        renderer.BeginFrame();
        TextureId image = Trace();
        static constexpr const char* kNames[] = {"mean", "m1", "m2", "m3", "m4",
                                                 "m5",   "m6", "m7", "m8", "m9"};
        for (int i = 0; i < accumulations; ++i) image = Accumulate(kNames[i], image);
        renderer.Present(Tonemap(image));
        ++count;
    }

    std::unique_ptr<rhi::Device> device;
    Renderer renderer;
    rhi::Tlas tlas;
    rhi::Buffer buffers[4];
    rhi::Texture environment;
    ResourceState tlasState, blasState, environmentState;
    ResourceState bufferStates[4];
    std::array<float, 32> parameters{};
    uint32_t count = 0;
};

// Declare, compile and record; submission and the wait for the device have counters of their own.
void Frame(benchmark::State& state) {
    Fixture fixture;
    const auto accumulations = static_cast<int>(state.range(0)) - 2;
    for (int i = 0; i < 20; ++i) {  // pipelines, memory
        fixture.DeclareFrame(accumulations);
        fixture.renderer.Execute();
    }
    fixture.renderer.TakeTimings();
    FrameTiming sum;
    double frames = 0.0;
    for (auto _ : state) {
        fixture.DeclareFrame(accumulations);
        const rhi::Submission value = fixture.renderer.Execute();
        fixture.device->WaitFor(value);
        const FrameTiming timing = fixture.renderer.Timing();
        sum.declareMs += timing.declareMs;
        sum.compileMs += timing.compileMs;
        sum.recordMs += timing.recordMs;
        sum.submitMs += timing.submitMs;
        state.SetIterationTime((timing.declareMs + timing.compileMs + timing.recordMs) * 1e-3);
        frames += 1.0;
    }
    state.counters["declare_us"] = 1e3 * sum.declareMs / frames;
    state.counters["compile_us"] = 1e3 * sum.compileMs / frames;
    state.counters["record_us"] = 1e3 * sum.recordMs / frames;
    state.counters["submit_us"] = 1e3 * sum.submitMs / frames;
}
BENCHMARK(Frame)->Name("Frame/passes")->Arg(3)->Arg(12)->UseManualTime()->Unit(benchmark::kMicrosecond);

// Compile alone, without a device: a chain of passes over transients that share memory.
void CompileChain(benchmark::State& state) {
    FrameGraph graph;
    graph.Begin(1);
    TextureId last;
    for (int i = 0; i < state.range(0); ++i) {
        TextureId target = graph.Add<ResourceKind::Texture>(
            {.name = "texture",
             .extent = {64, 64},
             .memory = {.size = 1 << 20, .alignment = 256, .memoryTypeBits = 1}});
        graph.AddPass("pass", PassKind::Compute);
        if (i > 0) graph.Use(last, Access::StorageRead);
        last = graph.Use(target, Access::StorageWrite);
    }
    graph.Present(last);
    for (auto _ : state) benchmark::DoNotOptimize(Compile(graph));
}
BENCHMARK(CompileChain)->Arg(3)->Arg(12)->Arg(100)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace raygraph

BENCHMARK_MAIN();
