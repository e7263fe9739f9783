// Runs a frame with a pass of its own, without scenes and pictures: it doubles numbers on the device.
#include <cstdio>

#include "renderer/graph/readback_values.h"
#include "renderer/graph/renderer.h"
#include "rhi/device.h"
#include "rhi/shader_compiler.h"

using namespace raygraph;  // NOLINT: an example

namespace {

constexpr const char* kDouble = R"(#version 460
layout(local_size_x = 8) in;
layout(binding = 0) buffer Numbers { uint values[]; } numbers;
void main() { numbers.values[gl_GlobalInvocationID.x] = 2u * gl_GlobalInvocationID.x; }
)";

std::vector<uint32_t> Doubled(Renderer& renderer) {
    renderer.AddShader("own/double.comp", rhi::CompileGlsl({.name = "own/double.comp", .text = kDouble}));
    renderer.BeginFrame();
    BufferId numbers = renderer.CreateBuffer("numbers", {.size = 8 * sizeof(uint32_t)});
    renderer.AddPass(
        "Double", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("own/double.comp");
            numbers = pass.Writes("numbers", numbers);
        },
        [](CommandList& commands) { commands.Dispatch(1, 1, 1); });
    const Readback readback = renderer.ReadBack(numbers);
    renderer.Execute();
    return WaitForValues<uint32_t>(readback);
}

}  // namespace

int main() {
    const auto device = rhi::Device::Create();
    Renderer renderer(*device);
    for (const uint32_t number : Doubled(renderer)) std::printf("%u ", number);
    std::puts("");
}
