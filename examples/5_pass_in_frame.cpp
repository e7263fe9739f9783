// pass_in_frame SCENE PICTURE.png: the pass of the first example in the path tracer's frame.
#include <cstdio>

#include "passes/accumulate.h"
#include "passes/tonemap.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/graph/readback_values.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/camera_view.h"
#include "sharpen.h"

using namespace raygraph;  // NOLINT: an example

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    const auto device = rhi::Device::Create();
    Renderer renderer(*device, {.shaderRoot = OWN_SHADERS, .shaderIncludes = {RAYGRAPH_SHADERS}});
    GpuScene scene(renderer);
    scene::SceneData data = scene::LoadGltf(argv[1]);
    passes::TraceSettings trace;
    trace.extent = {160, 160};
    trace.camera = ToRecord(scene::ChooseView(data, "", 1.0f));
    scene.SetScene(std::move(data));
    passes::Accumulation accumulation("picture");
    Readback picture;
    for (; trace.sampleIndex < 32; ++trace.sampleIndex) {  // a sample of every pixel and frame
        renderer.BeginFrame();
        TextureId sample = passes::Trace(renderer, scene.Declare(renderer), trace).radiance;
        TextureId mean = passes::Accumulate(renderer, sample, accumulation).mean;
        TextureId shown = passes::Tonemap(renderer, Sharpen(renderer, mean, 1.0f), {.isOpaque = true});
        picture = renderer.ReadBack(shown);
        renderer.Execute();
    }
    image::WritePng(argv[2], {.width = trace.extent.width,
                              .height = trace.extent.height,
                              .rgba = WaitForValues<uint8_t>(picture)});
}
