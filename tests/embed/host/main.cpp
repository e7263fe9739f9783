// host SCENE: a host engine that path-traces the Cornell box into its own image with the installed package.
// Exits with 1 if the red wall is not on the left and the green one on the right.
#include <cstdio>
#include <exception>

#include "gpu.h"
#include "passes/accumulate.h"
#include "passes/tonemap.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/scene/camera_view.h"
#include "renderer/scene/load_gltf.h"

using namespace raygraph;  // NOLINT: the example reads better

namespace {

constexpr Extent2D kExtent{64, 64};
constexpr uint32_t kSamples = 32;

void Render(const Gpu& gpu, VkImage picture, const char* scenePath) {
    rhi::AdoptedDeviceDesc desc;
    desc.instance = gpu.instance;
    desc.physicalDevice = gpu.physicalDevice;
    desc.device = gpu.device;
    desc.queue = gpu.queue;
    desc.queueFamily = gpu.queueFamily;
    desc.getInstanceProcAddr = vkGetInstanceProcAddr;
    desc.enabledExtensions = gpu.deviceExtensions;
    const auto device = rhi::Device::Adopt(desc);

    Renderer renderer(*device);
    GpuScene scene(renderer);
    scene::SceneData data = scene::LoadGltf(scenePath);
    passes::TraceSettings settings{.extent = kExtent};
    settings.camera = ToRecord(scene::ChooseView(data, "", 1.0f));
    scene.SetScene(std::move(data));

    const rhi::Texture target = device->WrapTexture(
        {.name = "host's picture", .extent = kExtent, .usage = rhi::TextureUsage::CopyDestination}, picture);
    ResourceState state;  // fresh: never used, contents undefined
    passes::Accumulation accumulation("picture");
    for (; settings.sampleIndex < kSamples; ++settings.sampleIndex) {
        renderer.BeginFrame();
        const SceneIds ids = scene.Declare(renderer);
        const TextureId sample = passes::Trace(renderer, ids, settings).radiance;
        const TextureId shown =
            passes::Tonemap(renderer, passes::Accumulate(renderer, sample, accumulation).mean);
        TextureId imported = renderer.Import("picture", target, state);
        renderer.AddPass(
            "Show", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(shown);
                imported = pass.CopiesTo(imported);
            },
            [shown, imported](CommandList& commands, const PassResources& resources) {
                commands.CopyTexture(resources.Texture(shown), resources.Texture(imported));
            });
        renderer.Export(imported, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        renderer.Execute();
    }
    device->WaitIdle();
}

// How much redder than green the columns [first, last) of the picture are, in 8-bit steps.
double Redness(const std::vector<std::array<uint8_t, 4>>& texels, uint32_t first, uint32_t last) {
    double sum = 0.0;
    for (uint32_t y = 0; y < kExtent.height; ++y)
        for (uint32_t x = first; x < last; ++x) {
            const auto& texel = texels[size_t{y} * kExtent.width + x];
            sum += double(texel[0]) - double(texel[1]);
        }
    return sum / (double(last - first) * kExtent.height);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("host SCENE\n", stderr);
        return 2;
    }
    try {
        Gpu gpu;
        Render(gpu, gpu.MakePicture(kExtent.width, kExtent.height), argv[1]);
        const auto texels = gpu.ReadPicture();
        const double left = Redness(texels, 2, 8), right = Redness(texels, 56, 62);
        std::printf("redness left %.1f, right %.1f\n", left, right);
        return left > 15.0 && right < -4.0 ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
