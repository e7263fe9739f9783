#include "rhi/swapchain.h"

#include <algorithm>

#include "base/text.h"
#include "rhi/command_list.h"

namespace raygraph::rhi {

namespace {

template <typename Item, typename Call>
std::vector<Item> All(Call&& call) {
    uint32_t count = 0;
    call(&count, nullptr);
    std::vector<Item> items(count);
    call(&count, items.data());
    items.resize(count);
    return items;
}

// Returns a format of eight bits per channel without conversion: the picture is already display-encoded.
VkSurfaceFormatKHR ChooseFormat(std::span<const VkSurfaceFormatKHR> formats, const std::string& subject) {
    for (const VkFormat wanted : {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM})
        for (const VkSurfaceFormatKHR& format : formats)
            if (format.format == wanted && format.colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR)
                return format;
    throw MakeError(ErrorKind::NoDevice, "{}: the surface has no format of 8 bits a channel", subject);
}

VkPresentModeKHR ChooseMode(std::span<const VkPresentModeKHR> modes, bool waitsForRefresh) {
    if (!waitsForRefresh)
        for (const VkPresentModeKHR wanted : {VK_PRESENT_MODE_MAILBOX_KHR, VK_PRESENT_MODE_IMMEDIATE_KHR})
            if (std::find(modes.begin(), modes.end(), wanted) != modes.end()) return wanted;
    return VK_PRESENT_MODE_FIFO_KHR;  // always supported
}

// Returns the extent of the surface, if it prescribes one.
Extent2D ChooseExtent(const VkSurfaceCapabilitiesKHR& surface, Extent2D wanted) {
    if (surface.currentExtent.width != 0xFFFFFFFFu)
        return {surface.currentExtent.width, surface.currentExtent.height};
    return {std::clamp(wanted.width, surface.minImageExtent.width, surface.maxImageExtent.width),
            std::clamp(wanted.height, surface.minImageExtent.height, surface.maxImageExtent.height)};
}

}  // namespace

Swapchain::Swapchain(Device& device, const SwapchainDesc& desc) : m_device(device), m_desc(desc) {
    if (!device.Vk().vkCreateSwapchainKHR || !device.InstanceVk().vkGetPhysicalDeviceSurfaceSupportKHR)
        throw MakeError(ErrorKind::Usage, "{}: the device was made without DeviceDesc::surfaceExtensions",
                        desc.name);
    if (!desc.makeSurface(device.Instance(), &m_surface))
        throw MakeError(ErrorKind::NoDevice, "{}: the window has no surface for Vulkan", desc.name);
    try {
        VkBool32 isSupported = VK_FALSE;
        device.Check(device.InstanceVk().vkGetPhysicalDeviceSurfaceSupportKHR(
                         device.PhysicalDevice(), device.QueueFamily(), m_surface, &isSupported),
                     desc.name + ": vkGetPhysicalDeviceSurfaceSupportKHR");
        if (!isSupported)
            throw MakeError(ErrorKind::NoDevice, "{}: {} cannot show pictures in this window", desc.name,
                            device.Info().name);
        for (uint32_t i = 0; i <= device.FramesInFlight(); ++i)
            m_slots.push_back({MakeSemaphore(Text("{} acquired {}", desc.name, i))});
        CreateImages(desc.extent);
    } catch (...) {
        Clear();
        throw;
    }
}

Swapchain::~Swapchain() {
    try {
        m_device.WaitQueueIdle();
    } catch (const Error&) {
        // The device is lost: there is nothing to wait for
    }
    Clear();
}

VkSemaphore Swapchain::MakeSemaphore(const std::string& name) {
    VkSemaphoreCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
    VkSemaphore semaphore = VK_NULL_HANDLE;
    m_device.Check(
        m_device.Vk().vkCreateSemaphore(m_device.Handle(), &info, m_device.AllocationCallbacks(), &semaphore),
        name + ": vkCreateSemaphore");
    m_device.SetName(VK_OBJECT_TYPE_SEMAPHORE, reinterpret_cast<uint64_t>(semaphore), name);
    return semaphore;
}

// Destroys everything, the surface included. The queue must be idle.
void Swapchain::Clear() {
    const DeviceFunctions& vk = m_device.Vk();
    m_textures.clear();
    const auto destroy = [&](VkSemaphore semaphore) {
        vk.vkDestroySemaphore(m_device.Handle(), semaphore, m_device.AllocationCallbacks());
    };
    for (const Slot& slot : m_slots) destroy(slot.acquired);
    for (const VkSemaphore semaphore : m_drawn) destroy(semaphore);
    m_slots.clear();
    m_drawn.clear();
    if (m_swapchain) vk.vkDestroySwapchainKHR(m_device.Handle(), m_swapchain, m_device.AllocationCallbacks());
    m_swapchain = VK_NULL_HANDLE;
    if (m_surface) m_device.InstanceVk().vkDestroySurfaceKHR(m_device.Instance(), m_surface, nullptr);
    m_surface = VK_NULL_HANDLE;
}

void Swapchain::CreateImages(Extent2D extent) {
    const DeviceFunctions& vk = m_device.Vk();
    const InstanceFunctions& instance = m_device.InstanceVk();
    const VkPhysicalDevice physical = m_device.PhysicalDevice();
    VkSurfaceCapabilitiesKHR surface{};
    m_device.Check(instance.vkGetPhysicalDeviceSurfaceCapabilitiesKHR(physical, m_surface, &surface),
                   m_desc.name + ": vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
    const Extent2D wanted = extent.IsEmpty() ? Extent2D{} : ChooseExtent(surface, extent);
    m_extent = {};                 // there are no images of that size yet
    if (wanted.IsEmpty()) return;  // the old swapchain stays, unused
    const VkSurfaceFormatKHR format =
        ChooseFormat(All<VkSurfaceFormatKHR>([&](uint32_t* count, VkSurfaceFormatKHR* formats) {
                         instance.vkGetPhysicalDeviceSurfaceFormatsKHR(physical, m_surface, count, formats);
                     }),
                     m_desc.name);
    m_format = FormatFromVk(format.format);

    VkSwapchainCreateInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR;
    info.surface = m_surface;
    info.minImageCount = std::max(surface.minImageCount, m_device.FramesInFlight() + 1);
    if (surface.maxImageCount > 0) info.minImageCount = std::min(info.minImageCount, surface.maxImageCount);
    info.imageFormat = format.format;
    info.imageColorSpace = format.colorSpace;
    info.imageExtent = {wanted.width, wanted.height};
    info.imageArrayLayers = 1;
    info.imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    info.imageSharingMode = VK_SHARING_MODE_EXCLUSIVE;
    info.preTransform = surface.currentTransform;
    info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
    info.presentMode =
        ChooseMode(All<VkPresentModeKHR>([&](uint32_t* count, VkPresentModeKHR* modes) {
                       instance.vkGetPhysicalDeviceSurfacePresentModesKHR(physical, m_surface, count, modes);
                   }),
                   m_desc.waitsForRefresh);
    info.clipped = VK_TRUE;
    info.oldSwapchain = m_swapchain;
    VkSwapchainKHR made = VK_NULL_HANDLE;
    const VkResult result =
        vk.vkCreateSwapchainKHR(m_device.Handle(), &info, m_device.AllocationCallbacks(), &made);
    // The old swapchain is retired, whatever the result
    m_textures.clear();
    if (m_swapchain) vk.vkDestroySwapchainKHR(m_device.Handle(), m_swapchain, m_device.AllocationCallbacks());
    m_swapchain = made;
    m_device.Check(result, m_desc.name + ": vkCreateSwapchainKHR");

    const std::vector<VkImage> images = All<VkImage>([&](uint32_t* count, VkImage* handles) {
        vk.vkGetSwapchainImagesKHR(m_device.Handle(), m_swapchain, count, handles);
    });
    for (const VkImage image : images)
        m_textures.push_back(
            m_device.WrapTexture({.name = Text("{} {}", m_desc.name, m_textures.size()),
                                  .extent = wanted,
                                  .format = m_format,
                                  .usage = TextureUsage::ColorTarget | TextureUsage::CopySource},
                                 image));
    while (m_drawn.size() < images.size())
        m_drawn.push_back(MakeSemaphore(Text("{} drawn {}", m_desc.name, m_drawn.size())));
    m_extent = wanted;
}

std::optional<SwapchainImage> Swapchain::Acquire() {
    if (m_extent.IsEmpty()) return std::nullopt;
    if (m_open) return m_open;
    Slot& slot = m_slots[m_nextSlot];
    m_device.WaitFor(slot.until);
    SwapchainImage image;
    const VkResult result = m_device.Vk().vkAcquireNextImageKHR(m_device.Handle(), m_swapchain, UINT64_MAX,
                                                                slot.acquired, VK_NULL_HANDLE, &image.index);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) return std::nullopt;
    m_device.Check(result, m_desc.name + ": vkAcquireNextImageKHR");
    image.texture = &m_textures[image.index];
    image.acquired = {.semaphore = slot.acquired};
    image.drawn = {.semaphore = m_drawn[image.index]};
    m_open = image;
    return image;
}

bool Swapchain::Present(const SwapchainImage& image, const Submission& drawn) {
    m_open.reset();
    m_slots[m_nextSlot].until = drawn;
    m_nextSlot = (m_nextSlot + 1) % m_slots.size();
    VkPresentInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR;
    info.waitSemaphoreCount = 1;
    info.pWaitSemaphores = &image.drawn.semaphore;
    info.swapchainCount = 1;
    info.pSwapchains = &m_swapchain;
    info.pImageIndices = &image.index;
    const VkResult result = m_device.Present(info);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) return false;
    m_device.Check(result, m_desc.name + ": vkQueuePresentKHR");
    return true;
}

void Swapchain::Resize(Extent2D extent) {
    if (m_open) {  // nothing has waited for its semaphore, which must not stay signaled
        m_device.Submit(m_device.BeginCommands(m_desc.name), {&m_open->acquired, 1});
        m_open.reset();
    }
    m_device.WaitQueueIdle();
    CreateImages(extent);
}

}  // namespace raygraph::rhi
