// What a host engine has before it embeds anything: a Vulkan device, pictures in its memory, and submissions
// of its own, which take turns with those of others on one timeline.
#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

using Texel = std::array<uint8_t, 4>;

class Gpu {
  public:
    Gpu();
    ~Gpu();
    Gpu(const Gpu&) = delete;
    Gpu& operator=(const Gpu&) = delete;

    // An rgba8 picture to be copied, cleared, and read by shaders; it lives as long as this object.
    VkImage MakePicture(VkExtent2D extent);
    // Vertices or indices, for shaders and acceleration structures to read by address; likewise.
    VkBuffer MakeVertices(const void* data, size_t bytes);
    // While nothing reads them.
    void SetVertices(VkBuffer vertices, const void* data, size_t bytes);
    // Fills the picture, whatever it held, and leaves it in TRANSFER_DST_OPTIMAL.
    void Clear(VkImage picture, std::array<float, 4> color);
    // The texels of a picture in TRANSFER_SRC_OPTIMAL, rows from the top; waits for them.
    std::vector<Texel> Read(VkImage picture, VkExtent2D extent);

    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t queueFamily = 0;
    std::vector<std::string> deviceExtensions;
    std::mutex queueLock;  // of all that is submitted

    // What is submitted next waits for `turn` and signals the value after it.
    VkSemaphore timeline = VK_NULL_HANDLE;
    uint64_t turn = 0;

  private:
    struct Owned {
        VkImage image = VK_NULL_HANDLE;
        VkBuffer buffer = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
    };
    VkDeviceMemory Allocate(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags properties,
                            VkMemoryAllocateFlags flags = 0);
    // Submits in turn what `record` records, and waits for it.
    void Run(const std::function<void(VkCommandBuffer)>& record);

    std::vector<Owned> m_owned;
    VkCommandPool m_pool = VK_NULL_HANDLE;
};
