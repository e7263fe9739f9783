// HostImage shows a viewport's picture in an image of the host: the only header of this folder with Vulkan
// types.
//
//   HostImage target(device, {.image = hostImage, .extent = {1280, 720}, .format = rhi::Format::Bgra8Unorm});
//   ... every frame ...
//   renderer.BeginFrame();
//   TextureId shown = viewport.Declare();
//   if (shown.IsValid()) target.Show(renderer, shown, {.wait = {hostIsDone}, .signal = {weAreDone}});
//   renderer.Execute();
//   ... the host samples its image, then says how it left it, if it did more than that:
//   target.Return(VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
//
// Threads: that of the Renderer.
#pragma once

#include <string>
#include <vector>

#include "base/api.h"
#include "renderer/graph/renderer.h"
#include "rhi/device.h"

namespace raygraph::viewport {

struct HostImageDesc {
    std::string name = "host image";
    VkImage image = VK_NULL_HANDLE;
    Extent2D extent{};  // pixels
    // Rgba8Unorm and Rgba8Srgb: the image needs VK_IMAGE_USAGE_TRANSFER_DST_BIT. All others:
    // VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT. Its texels are display-encoded; in an sRGB format, the decoded
    // values are.
    rhi::Format format = rhi::Format::Rgba8Unorm;
    // The layout in which the host gets the image back; it is released to `queueFamilyAfter`, unless that is
    // the device's own family or ignored.
    VkImageLayout layoutAfter = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    uint32_t queueFamilyAfter = VK_QUEUE_FAMILY_IGNORED;
};

// Holds binary (value 0) or timeline semaphores of the host, for the submission of the frame.
struct HostSemaphores {
    std::vector<rhi::SemaphoreUse> wait;
    std::vector<rhi::SemaphoreUse> signal;
};

// An image that the host owns. The image outlives the frames that show in it, and so does this object,
// which tracks the layout from frame to frame. Threads: that of the Renderer.
class RAYGRAPH_API HostImage {
  public:
    // Throws Error{Usage} for a null image, an empty extent or an unsupported format.
    HostImage(rhi::Device& device, const HostImageDesc& desc);
    HostImage(const HostImage&) = delete;
    HostImage& operator=(const HostImage&) = delete;

    // Declares into the open frame that `picture`, a viewport's, replaces the image's contents, and that the
    // image is handed back. Throws Error{Usage} for a picture of another extent.
    void Show(Renderer& renderer, TextureId picture, const HostSemaphores& semaphores = {});
    // Tells that the host has used the image since: it has this layout now, and was released by
    // `queueFamily`, if that differs from the device's family (with oldLayout = newLayout = layout). Without
    // this call, the image is as Show left it. Only while no frame is open.
    void Return(VkImageLayout layout, uint32_t queueFamily = VK_QUEUE_FAMILY_IGNORED);

    const HostImageDesc& Desc() const { return m_desc; }

  private:
    HostImageDesc m_desc;
    rhi::Texture m_texture;
    ResourceState m_state;
};

}  // namespace raygraph::viewport
