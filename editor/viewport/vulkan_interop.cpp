#include "editor/viewport/vulkan_interop.h"

#include "base/text.h"
#include "passes/show.h"

namespace raygraph::viewport {

namespace {

// Returns whether the format has the same bytes as the picture.
bool IsCopied(rhi::Format format) {
    return format == rhi::Format::Rgba8Unorm || format == rhi::Format::Rgba8Srgb;
}

std::string SizeOf(Extent2D extent) {
    return Text("{}x{}", extent.width, extent.height);
}

}  // namespace

HostImage::HostImage(rhi::Device& device, const HostImageDesc& desc) : m_desc(desc) {
    if (desc.image == VK_NULL_HANDLE || desc.extent.IsEmpty())
        throw MakeError(ErrorKind::Usage, "HostImage \"{}\": there is no image, or it is of {} pixels",
                        desc.name, SizeOf(desc.extent));
    if (desc.format == rhi::Format::Undefined || rhi::IsDepth(desc.format) || rhi::IsUint(desc.format))
        throw MakeError(ErrorKind::Usage, "HostImage \"{}\": no picture is shown in {}", desc.name,
                        rhi::Name(desc.format));
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
        throw MakeError(ErrorKind::Usage, "HostImage \"{}\" of {}: a picture of {}", m_desc.name,
                        SizeOf(m_desc.extent), SizeOf(extent));
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
