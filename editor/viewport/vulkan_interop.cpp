#include "editor/viewport/vulkan_interop.h"

#include "base/error.h"
#include "passes/show.h"

namespace raygraph::viewport {

namespace {

// Formats with the same bytes as the picture.
bool IsCopied(rhi::Format format) {
    return format == rhi::Format::Rgba8Unorm || format == rhi::Format::Rgba8Srgb;
}

std::string SizeOf(Extent2D extent) {
    return std::to_string(extent.width) + "x" + std::to_string(extent.height);
}

}  // namespace

HostImage::HostImage(rhi::Device& device, const HostImageDesc& desc) : m_desc(desc) {
    if (desc.image == VK_NULL_HANDLE || desc.extent.IsEmpty())
        throw Error(ErrorKind::Usage, "HostImage \"" + desc.name + "\": there is no image, or it is of " +
                                          SizeOf(desc.extent) + " pixels");
    if (desc.format == rhi::Format::Undefined || rhi::IsDepth(desc.format) ||
        desc.format == rhi::Format::R32Uint || desc.format == rhi::Format::Rg32Uint ||
        desc.format == rhi::Format::Rgba32Uint)
        throw Error(ErrorKind::Usage,
                    "HostImage \"" + desc.name + "\": no picture is shown in " + rhi::Name(desc.format));
    m_texture = device.WrapTexture({.name = desc.name,
                                    .extent = desc.extent,
                                    .format = desc.format,
                                    .usage = IsCopied(desc.format) ? rhi::TextureUsage::CopyDestination
                                                                   : rhi::TextureUsage::ColorTarget},
                                   desc.image);
}

void HostImage::Show(Renderer& renderer, TextureId picture, const HostSemaphores& semaphores) {
    // First, so that a frame that fails below can forward them.
    for (const rhi::SemaphoreUse& semaphore : semaphores.wait) renderer.WaitSemaphore(semaphore);
    for (const rhi::SemaphoreUse& semaphore : semaphores.signal) renderer.SignalSemaphore(semaphore);
    const Extent2D extent = renderer.Desc(picture).extent;
    if (!(extent == m_desc.extent))
        throw Error(ErrorKind::Usage, "HostImage \"" + m_desc.name + "\" of " + SizeOf(m_desc.extent) +
                                          ": a picture of " + SizeOf(extent));
    TextureId target = renderer.Import(m_desc.name, m_texture, m_state);
    if (IsCopied(m_desc.format))
        renderer.AddPass(
            "ShowInHostImage", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(picture);
                target = pass.CopiesTo(target);
            },
            [picture, target](CommandList& commands, const PassResources& resources) {
                commands.CopyTexture(resources.Texture(picture), resources.Texture(target));
            });
    else
        target = passes::Show(renderer, picture, target);
    renderer.Export(target, m_desc.layoutAfter, m_desc.queueFamilyAfter);
}

void HostImage::Return(VkImageLayout layout, uint32_t queueFamily) {
    m_state = {
        .readStages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, .layout = layout, .queueFamily = queueFamily};
}

}  // namespace raygraph::viewport
