// Swapchain: the images that a window presents.
//
//   while (std::optional<SwapchainImage> image = swapchain.Acquire()) {
//       ... a submission that waits for image->acquired, leaves image->texture in PRESENT_SRC_KHR and
//           signals image->drawn ...
//       if (!swapchain.Present(*image, that submission)) break;
//   }
//   swapchain.Resize(size of the window);
//
// Threads: one at a time.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "rhi/device.h"
#include "rhi/resources.h"

namespace raygraph::rhi {

using MakeSurface = std::function<bool(VkInstance instance, VkSurfaceKHR* surface)>;

struct SwapchainDesc {
    std::string name = "swapchain";
    // Creates the window's surface; the Swapchain destroys it. Returns false if there is none.
    MakeSurface makeSurface = {};
    Extent2D extent = {};         // the window's extent in pixels; empty: minimized, Acquire returns nothing
    bool waitsForRefresh = true;  // false: frames are shown as fast as they come, if the device supports it
};

struct SwapchainImage {
    const Texture* texture = nullptr;  // contents undefined; color target and copy source
    uint32_t index = 0;
    SemaphoreUse acquired;  // semaphore to wait for
    SemaphoreUse drawn;     // semaphore to signal
};

class Swapchain {
  public:
    // Throws Error{NoDevice} if the device cannot present to the surface, and Error{Vulkan} with the call
    // that failed. `device` must outlive the object.
    Swapchain(Device& device, const SwapchainDesc& desc);
    ~Swapchain();  // waits for the queue
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    // Returns the next image, for which it may wait. An image that was acquired and not presented is returned
    // again. Returns nullopt if the window has another size, or none: call Resize.
    std::optional<SwapchainImage> Acquire();
    // Presents what the submission `drawn` draws. Returns false if the window has another size: call Resize.
    // The image counts as presented.
    bool Present(const SwapchainImage& image, const Submission& drawn);
    // Waits for the queue and creates images of that extent, or of the one that the surface prescribes.
    void Resize(Extent2D extent);

    Extent2D Extent() const { return m_extent; }
    rhi::Format Format() const { return m_format; }

  private:
    struct Slot {
        VkSemaphore acquired = VK_NULL_HANDLE;
        Submission until;  // waits for it
    };

    void CreateImages(Extent2D extent);
    void Clear();
    VkSemaphore MakeSemaphore(const std::string& name);

    Device& m_device;
    SwapchainDesc m_desc;
    VkSurfaceKHR m_surface = VK_NULL_HANDLE;
    VkSwapchainKHR m_swapchain = VK_NULL_HANDLE;
    rhi::Format m_format = rhi::Format::Undefined;
    Extent2D m_extent;
    std::vector<Texture> m_textures;
    std::vector<VkSemaphore> m_drawn;  // one an image
    std::vector<Slot> m_slots;
    size_t m_nextSlot = 0;
    std::optional<SwapchainImage> m_open;
};

}  // namespace raygraph::rhi
