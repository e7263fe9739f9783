// check SCENE MISSING: uses something of every layer, so that all of what pkg-config names is linked. Exits
// with 1 if the scene does not come to the device, or if the missing file is not refused as documented.
#include <cstdio>
#include <exception>

#include "base/error.h"
#include "base/version.h"
#include "editor/viewport/viewport.h"
#include "renderer/graph/plan_text.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "rhi/reflection.h"
#include "rhi/shader_compiler.h"

using namespace raygraph;  // NOLINT: an example

namespace {

// Checks that an exception of the library can be caught by its type.
bool IsRefused(const char* file) {
    try {
        scene::LoadGltf(file);
    } catch (const Error& error) {
        return error.Kind() == ErrorKind::Io;
    }
    return false;
}

// Describes a graph of the host's own, for its tools.
bool IsDescribed() {
    FrameGraph graph;
    graph.Begin(1);
    const TextureId picture = graph.Add<ResourceKind::Texture>({.name = "picture", .extent = {4, 2}});
    graph.AddPass("Draw", PassKind::Compute);
    graph.Present(graph.Use(picture, Access::StorageWrite));
    return ResourceText(graph.resources[0]).starts_with("texture 4x2");
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    try {
        const auto words = rhi::CompileGlsl(
            {.name = "empty.comp", .text = "#version 460\nlayout(local_size_x = 4) in;\nvoid main() {}\n"});
        const rhi::ShaderReflection reflection = rhi::Reflect(words);
        const auto device = rhi::Device::Create();
        Renderer renderer(*device);
        GpuScene scene(renderer);
        scene.SetScene(scene::LoadGltf(argv[1]));
        const viewport::Viewport viewport(renderer, scene);
        std::printf("%u instances, workgroups of %u\n", scene.Statistics().instanceCount,
                    reflection.workgroupSize[0]);
        const bool isAsExpected = LibraryVersion() == kHeaderVersion &&
                                  scene.Statistics().instanceCount > 0 && reflection.workgroupSize[0] == 4 &&
                                  IsRefused(argv[2]) && IsDescribed();
        return isAsExpected ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
