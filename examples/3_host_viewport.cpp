// host_viewport SCENE PICTURE.png: shows a scene in an image of the host, on the host's own VkDevice.
#include <cstdio>
#include <cstring>
#include <exception>

#include "3_host.h"
#include "editor/viewport/viewport.h"
#include "editor/viewport/vulkan_interop.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "rhi/transfer.h"

using namespace raygraph;  // NOLINT: an example

namespace {

// Shows so many frames. An engine shows them as long as its panel is open, between its own submissions.
void ShowScene(rhi::Device& device, VkImage hostImage, Extent2D size, const char* file, int frames) {
    Renderer renderer(device);
    GpuScene scene(renderer);
    scene::SceneData data = scene::LoadGltf(file);
    viewport::Viewport viewport(renderer, scene, {.size = size});
    viewport.SetCamera(scene::ChooseView(data, "", float(size.width) / float(size.height)));
    scene.SetScene(std::move(data));
    viewport::HostImage panel(device, {.image = hostImage, .extent = size});
    for (int frame = 0; frame < frames; ++frame) {  // each adds a sample of every pixel
        renderer.BeginFrame();
        TextureId shown = viewport.Declare();
        if (shown.IsValid()) panel.Show(renderer, shown);
        renderer.Execute();  // one submission; the image is in SHADER_READ_ONLY_OPTIMAL
    }
}

void WritePicture(rhi::Device& device, VkImage hostImage, Extent2D size, const char* file) {
    const rhi::Texture wrapped = device.WrapTexture(
        {.name = "host image", .extent = size, .usage = rhi::TextureUsage::CopySource}, hostImage);
    const auto bytes = rhi::ReadTexture(device, wrapped, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    image::Image8 picture{
        .width = size.width, .height = size.height, .rgba = std::vector<uint8_t>(bytes.size())};
    std::memcpy(picture.rgba.data(), bytes.data(), bytes.size());
    image::WritePng(file, picture);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    try {
        Host host;
        const auto owner = rhi::Device::Adopt({.instance = host.instance,
                                               .physicalDevice = host.physicalDevice,
                                               .device = host.device,
                                               .queue = host.queue,
                                               .queueFamily = host.queueFamily,
                                               .getInstanceProcAddr = vkGetInstanceProcAddr,
                                               .enabledExtensions = host.extensions});
        rhi::Device& device = *owner;
        const Extent2D size{160, 160};
        host.image = host.MakeImage({size.width, size.height}, host.imageMemory);
        ShowScene(device, host.image, size, argv[1], 32);
        WritePicture(device, host.image, size, argv[2]);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
