// Gpu is what a host engine has before it embeds anything: a Vulkan device, images and vertices in its memory,
// and submissions that take turns with those of others on one timeline.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <mutex>

#include "3_host.h"

using Texel = std::array<uint8_t, 4>;

class Gpu : public Host {
  public:
    Gpu();
    ~Gpu();

    // Makes an rgba8 image to be copied, cleared, and read by shaders; it lives as long as this object.
    VkImage MakePicture(VkExtent2D extent);
    // Makes vertices or indices that shaders and acceleration structures read by address; they live as long,
    // too.
    VkBuffer MakeVertices(const void* data, size_t bytes);
    // Call this only while nothing reads the buffer.
    void SetVertices(VkBuffer vertices, const void* data, size_t bytes);
    // Fills the picture, whose old content is lost, and leaves it in TRANSFER_DST_OPTIMAL.
    void Clear(VkImage picture, std::array<float, 4> color);
    // Returns the texels of a picture in TRANSFER_SRC_OPTIMAL, rows from the top; waits for them.
    std::vector<Texel> Read(VkImage picture, VkExtent2D extent);

    std::mutex queueLock;  // guards all submissions
    std::mutex messageLock;
    std::vector<std::string> messages;  // of the library

    // The next submission waits for `turn`, and signals the value after it.
    VkSemaphore timeline = VK_NULL_HANDLE;
    uint64_t turn = 0;

  private:
    struct Owned {
        VkImage image = VK_NULL_HANDLE;
        VkBuffer buffer = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
    };
    // Submits what `record` records when its turn comes, and waits for it.
    void Run(const std::function<void(VkCommandBuffer)>& record);

    std::vector<Owned> m_owned;
    VkCommandPool m_pool = VK_NULL_HANDLE;
};
