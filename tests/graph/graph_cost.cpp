// Measures what a frame of N passes costs the CPU: declaring, compiling and recording it apart, and how often
// each of them allocates. It needs raygraph::graph alone and prints the table of docs/graph.md.
//
//   raygraph_graph_cost [--frames N] [--loop] [PASSES...]
//
// The allocations are those of all frames, in declaring and compiling, and in executing. It fails if frames
// like the one before make any. "Loop" stands for frames that are not executed, as other engines measure; "no
// driver" for commands that are not recorded.
//
// Every pass reads one or two textures and writes one; some also update a buffer or a texture that persists,
// and some lead to nothing and are culled. The textures have one texel, so that the device has little to do.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "base/median.h"
#include "base/text.h"
#include "renderer/graph/renderer.h"
#include "rhi/functions.h"
#include "rhi/shader_compiler.h"
#include "tests/support/failing_memory.h"

namespace raygraph {
namespace {

constexpr std::string_view kMixShader = R"(#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba16f) uniform readonly image2D first;
layout(binding = 1, rgba16f) uniform readonly image2D second;
layout(binding = 2, rgba16f) uniform writeonly image2D mixed;
layout(push_constant, std430) uniform Constants { vec4 weights; } constants;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(mixed, texel, constants.weights.x * imageLoad(first, texel) + imageLoad(second, texel));
})";
constexpr std::string_view kFilterShader = R"(#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D source;
layout(binding = 1, rgba16f) uniform writeonly image2D filtered;
layout(push_constant, std430) uniform Constants { vec4 weights; } constants;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(filtered, texel, constants.weights * texelFetch(source, texel, 0));
})";
constexpr std::string_view kCountShader = R"(#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba16f) uniform readonly image2D source;
layout(binding = 1, rgba16f) uniform writeonly image2D counted;
layout(binding = 2, std430) buffer Counts { uint counts[]; };
layout(push_constant, std430) uniform Constants { vec4 weights; } constants;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    vec4 value = imageLoad(source, texel);
    atomicAdd(counts[uint(value.x) & 63u], 1u);
    imageStore(counted, texel, value * constants.weights);
})";
constexpr std::string_view kBlendShader = R"(#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba16f) uniform readonly image2D source;
layout(binding = 1, rgba16f) uniform image2D history;
layout(push_constant, std430) uniform Constants { vec4 weights; } constants;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(history, texel, mix(imageLoad(history, texel), imageLoad(source, texel), constants.weights));
})";

constexpr Extent2D kExtent{1, 1};
constexpr GraphTextureDesc kTexture{.extent = kExtent, .format = Format::Rgba16Float};
constexpr std::array<float, 4> kWeights{0.5f, 0.5f, 0.5f, 0.5f};

// Declares frames of a number of passes. Its names are made once, since a host has them as literals.
class Frames {
  public:
    Frames(Renderer& renderer, uint32_t passes) : m_renderer(renderer), m_passCount(passes) {
        for (uint32_t p = 0; p < passes; ++p) {
            m_passNames.push_back(Text("pass number {}", p));
            m_textureNames.push_back(Text("result of pass number {}", p));
        }
    }

    // With `isOdd`, another pass is culled and another texture is shown: the plan differs.
    void Declare(bool isOdd) {
        TextureId before = Source(), last = before;
        BufferId counts = m_renderer.CreateBuffer("counts", {.size = 256});
        counts = Clear(counts);
        for (uint32_t p = 2; p < m_passCount; ++p) {
            const std::string& name = m_passNames[p];
            TextureId result;
            if (p % 16 == 9) {
                result = Blend(p, last);
            } else {
                result = m_renderer.CreateTexture(m_textureNames[p], kTexture);
                if (p % 8 == 5)
                    Count(name, last, result, counts);
                else if (p % 2 == 0)
                    Mix(name, last, before, result);
                else
                    Filter(name, last, result);
            }
            const bool leadsToNothing = p % 12 == (isOdd ? 6 : 7);
            if (leadsToNothing) continue;
            before = last;
            last = result;
        }
        m_renderer.Present(isOdd ? before : last);
    }

  private:
    TextureId Source() {
        TextureId source = m_renderer.CreateTexture(m_textureNames[0], kTexture);
        m_renderer.AddPass(
            m_passNames[0], PassKind::Transfer, [&](PassBuilder& pass) { source = pass.CopiesTo(source); },
            [source](CommandList& commands, const PassResources& resources) {
                commands.Clear(resources.Texture(source), {0.0f, 0.0f, 0.0f, 0.0f});
            });
        return source;
    }
    BufferId Clear(BufferId counts) {
        m_renderer.AddPass(
            m_passNames[1], PassKind::Transfer, [&](PassBuilder& pass) { counts = pass.CopiesTo(counts); },
            [counts](CommandList& commands, const PassResources& resources) {
                commands.Fill(resources.Buffer(counts), 0);
            });
        return counts;
    }
    void Mix(std::string_view name, TextureId first, TextureId second, TextureId& result) {
        m_renderer.AddPass(
            name, PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("cost/mix.comp");
                pass.Reads("first", first);
                pass.Reads("second", second);
                result = pass.Writes("mixed", result);
                pass.Constants(kWeights);
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
    }
    void Filter(std::string_view name, TextureId source, TextureId& result) {
        m_renderer.AddPass(
            name, PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("cost/filter.comp");
                pass.Reads("source", source, rhi::SamplerDesc{});
                result = pass.Writes("filtered", result);
                pass.Constants(kWeights);
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
    }
    void Count(std::string_view name, TextureId source, TextureId& result, BufferId& counts) {
        m_renderer.AddPass(
            name, PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("cost/count.comp");
                pass.Reads("source", source);
                result = pass.Writes("counted", result);
                counts = pass.Updates("Counts", counts);
                pass.Constants(kWeights);
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
    }
    TextureId Blend(uint32_t p, TextureId source) {
        TextureId history = m_renderer.Persist(m_textureNames[p], kTexture);
        m_renderer.AddPass(
            m_passNames[p], PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("cost/blend.comp");
                pass.Reads("source", source);
                history = pass.Updates("history", history);
                pass.Constants(kWeights);
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
        return history;
    }

    Renderer& m_renderer;
    uint32_t m_passCount;
    std::vector<std::string> m_passNames;
    std::vector<std::string> m_textureNames;
};

// The measured values of one step over many frames.
struct Cost {
    std::vector<double> microseconds;
    size_t allocations = 0;  // in all frames

    template <typename Run>
    void Measure(Run&& run) {
        const size_t allocationsBefore = testing::AllocationCount();
        const auto begin = std::chrono::steady_clock::now();
        run();
        const std::chrono::duration<double, std::micro> elapsed = std::chrono::steady_clock::now() - begin;
        allocations += testing::AllocationCount() - allocationsBefore;
        microseconds.push_back(elapsed.count());
    }
    std::string Text() const {
        return raygraph::Text("{:8.2f} ({:8.2f})", Median(microseconds), std::ranges::min(microseconds));
    }
};

struct Costs {
    Cost declare, compile, execute;
};

enum class Mode : uint8_t {
    Loop,       // frames that are declared and compiled, one after the other, and not executed
    Equal,      // executed frames, each like the one before
    Different,  // executed frames, each unlike the one before
};

Costs MeasureFrames(Renderer& renderer, uint32_t passes, int frames, Mode mode) {
    Frames scene(renderer, passes);
    Costs costs;
    const int warmUp = 32 + frames / 4;
    for (int f = 0; f < warmUp + frames; ++f) {
        if (f == warmUp) costs = {};
        renderer.BeginFrame();
        costs.declare.Measure([&] { scene.Declare(mode == Mode::Different && f % 2 == 1); });
        costs.compile.Measure([&] { renderer.Compile(); });
        if (mode == Mode::Loop) {
            renderer.DropFrame();
            continue;
        }
        costs.execute.Measure([&] { renderer.Execute(); });
        renderer.Device().WaitIdle();
    }
    return costs;
}

void AddShaders(Renderer& renderer) {
    const std::pair<std::string_view, std::string_view> shaders[] = {{"cost/mix.comp", kMixShader},
                                                                     {"cost/filter.comp", kFilterShader},
                                                                     {"cost/count.comp", kCountShader},
                                                                     {"cost/blend.comp", kBlendShader}};
    for (const auto& [name, text] : shaders) {
        rhi::GlslSource source;
        source.name = name;
        source.text = text;
        renderer.AddShader(name, rhi::CompileGlsl(source));
    }
}

// Replaces the functions that record commands, so that what remains is the graph's own work.
void RecordNothing(rhi::Device& device) {
    auto& vk = const_cast<rhi::DeviceFunctions&>(device.Vk());
    const auto ignore = []<typename... Arguments>(void (*&function)(Arguments...)) {
        function = [](Arguments...) {};
    };
    ignore(vk.vkCmdPipelineBarrier2);
    ignore(vk.vkCmdBindPipeline);
    ignore(vk.vkCmdPushDescriptorSetKHR);
    ignore(vk.vkCmdPushConstants);
    ignore(vk.vkCmdDispatch);
    ignore(vk.vkCmdFillBuffer);
    ignore(vk.vkCmdClearColorImage);
}

Costs MeasureMode(rhi::Device& device, uint32_t passes, int frames, Mode mode) {
    Renderer renderer(device, {.gpuTimes = false, .keptTimings = 0});
    AddShaders(renderer);
    return MeasureFrames(renderer, passes, frames, mode);
}

// Runs the loop alone, for profilers.
void RunLoop(std::span<const uint32_t> passCounts, int frames) {
    const auto device = rhi::Device::Create({.debugNames = false, .savePipelineCache = false});
    for (const uint32_t passes : passCounts) {
        const Costs loop = MeasureMode(*device, passes, frames, Mode::Loop);
        std::printf("%u passes: declare %s compile %s\n", passes, loop.declare.Text().c_str(),
                    loop.compile.Text().c_str());
    }
}

// Returns whether frames like the one before have allocated nothing.
bool Print(std::span<const uint32_t> passCounts, int frames) {
    const auto device = rhi::Device::Create({.debugNames = false, .savePipelineCache = false});
    const auto silent = rhi::Device::Create({.debugNames = false, .savePipelineCache = false});
    RecordNothing(*silent);
    std::printf("%d frames, microseconds: median (least)\n\n", frames);
    std::puts(
        "| passes | declare, loop       | compile, loop       | declare             | compile             "
        "| compile, changed    | execute, no driver  | execute             | allocations |\n"
        "|-------:|--------------------:|--------------------:|--------------------:|--------------------:"
        "|--------------------:|--------------------:|--------------------:|------------:|");
    size_t allocations = 0;
    for (const uint32_t passes : passCounts) {
        const Costs loop = MeasureMode(*silent, passes, frames, Mode::Loop);
        const Costs own = MeasureMode(*silent, passes, frames, Mode::Equal);
        const Costs changed = MeasureMode(*silent, passes, frames, Mode::Different);
        const Costs equal = MeasureMode(*device, passes, frames, Mode::Equal);
        const size_t planning = equal.declare.allocations + equal.compile.allocations;
        std::printf("| %6u | %s | %s | %s | %s | %s | %s | %s | %4zu + %4zu |\n", passes,
                    loop.declare.Text().c_str(), loop.compile.Text().c_str(), equal.declare.Text().c_str(),
                    equal.compile.Text().c_str(), changed.compile.Text().c_str(), own.execute.Text().c_str(),
                    equal.execute.Text().c_str(), planning, equal.execute.allocations);
        std::fflush(stdout);
        allocations += planning + equal.execute.allocations;
    }
    return allocations == 0;
}

}  // namespace
}  // namespace raygraph

int main(int argc, char** argv) {
    int frames = 1000;
    bool isLoop = false;
    std::vector<uint32_t> passes;
    for (int i = 1; i < argc; ++i) {
        if (std::string_view(argv[i]) == "--frames" && i + 1 < argc)
            frames = std::atoi(argv[++i]);
        else if (std::string_view(argv[i]) == "--loop")
            isLoop = true;
        else
            passes.push_back(static_cast<uint32_t>(std::atoi(argv[i])));
    }
    if (passes.empty()) passes = {19, 50, 100, 500};
    if (isLoop) {
        raygraph::RunLoop(passes, frames);
        return 0;
    }
    return raygraph::Print(passes, frames) ? 0 : 1;
}
