// edit_live_scene ROOM ADDED PICTURE.png: moves a block of the scene that is shown, and streams another file
// into it.
#include <cstdio>
#include <future>

#include "editor/viewport/viewport.h"
#include "renderer/graph/readback_values.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/load_gltf.h"

using namespace raygraph;  // NOLINT: an example

namespace {

Readback ShowFrame(Renderer& renderer, viewport::Viewport& viewport) {
    renderer.BeginFrame();
    Readback picture = renderer.ReadBack(viewport.Declare());
    renderer.Execute();
    return picture;
}

void Move(GpuScene& scene, uint32_t instance, glm::vec3 by) {
    scene::PlacedTransform placed = scene.Transform(instance);
    placed.matrix[3] += by;
    scene.SetTransform(instance, placed);  // the next frame updates the TLAS and restarts the mean
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) return 2;
    const auto device = rhi::Device::Create();
    Renderer renderer(*device);
    GpuScene scene(renderer);
    scene::SceneData data = scene::LoadGltf(argv[1]);
    viewport::Viewport viewport(renderer, scene, {.size = {160, 160}});
    viewport.SetCamera(scene::ChooseView(data, "", 1.0f));
    scene.SetScene(std::move(data));

    // Reading and preparing use no device: they run beside the frames.
    auto coming = std::async(std::launch::async, [argv] { return PreparedScene(scene::LoadGltf(argv[2])); });
    for (int frame = 0; frame < 16; ++frame) ShowFrame(renderer, viewport);
    const uint32_t before = viewport.Progress().pathTracedSamples;

    const std::shared_ptr<const AddedPart> part = scene.Stream(coming.get());
    while (!part->isComplete) ShowFrame(renderer, viewport);  // each frame copies and builds a little
    for (uint32_t i = 0; i < 3; ++i) Move(scene, part->instances[i], {0.1f, 0.165f, 0.11f});
    for (uint32_t i = 3; i < 5; ++i) scene.SetVisible(part->instances[i], false);  // its table and its lamp
    Move(scene, 2, {0.0f, 0.0f, -0.05f});  // the tall block of the room

    Readback picture;
    for (int frame = 0; frame < 64; ++frame) picture = ShowFrame(renderer, viewport);
    image::WritePng(argv[3], {.width = 160, .height = 160, .rgba = WaitForValues<uint8_t>(picture)});
    scene.Remove(*part);
    std::printf("%u samples, then %u of the edited scene\n", before, viewport.Progress().pathTracedSamples);
}
