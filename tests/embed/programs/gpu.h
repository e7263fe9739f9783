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
    using Record = std::function<void(VkCommandBuffer)>;
    // Returns the texels of a picture in TRANSFER_SRC_OPTIMAL, rows from the top; waits for them. `before` is
    // recorded before the copy, into the same command buffer.
    std::vector<Texel> Read(VkImage picture, VkExtent2D extent, const Record& before = {});
    // Binds the host's heap, a descriptor set of many textures, for compute shaders.
    void BindHeap(VkCommandBuffer commands) const;
    // Draws a square into the upper left corner of a picture, which was and is in TRANSFER_SRC_OPTIMAL.
    void DrawSquare(VkCommandBuffer commands, VkImage picture, uint32_t side, std::array<float, 4> color);

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
    void Run(const Record& record);
    void MakeHeap();

    std::vector<Owned> m_owned;
    std::vector<VkImageView> m_views;
    VkDescriptorSetLayout m_heapLayout = VK_NULL_HANDLE;
    VkPipelineLayout m_layout = VK_NULL_HANDLE;
    VkDescriptorPool m_heapPool = VK_NULL_HANDLE;
    VkDescriptorSet m_heap = VK_NULL_HANDLE;
    VkCommandPool m_pool = VK_NULL_HANDLE;
};
