// What a host engine has before it embeds anything: a Vulkan device and a picture in its memory.
#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

class Gpu {
  public:
    Gpu();
    ~Gpu();
    Gpu(const Gpu&) = delete;
    Gpu& operator=(const Gpu&) = delete;

    // An rgba8 picture that can be copied to and from; it lives as long as this object. Once.
    VkImage MakePicture(uint32_t width, uint32_t height);
    // The picture's texels, rows from the top; it is in TRANSFER_SRC_OPTIMAL.
    std::vector<std::array<uint8_t, 4>> ReadPicture();

    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t queueFamily = 0;
    std::vector<std::string> deviceExtensions;

  private:
    VkDeviceMemory Allocate(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags properties);

    VkImage m_picture = VK_NULL_HANDLE;
    VkDeviceMemory m_pictureMemory = VK_NULL_HANDLE;
    uint32_t m_width = 0;
    uint32_t m_height = 0;
};
