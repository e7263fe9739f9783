// Readback: bytes that are copied from the device to the CPU, and blocking short forms for tests and
// programs. Threads: one object for one thread at a time; the short forms may be called from any.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/api.h"
#include "rhi/command_list.h"
#include "rhi/resources.h"

namespace raygraph::rhi {

// Copies are recorded into the caller's list, so that they run right after the commands that write the data.
// The caller submits the list and passes its timeline value. One thread at a time.
class RAYGRAPH_API Readback {
  public:
    Readback() = default;

    // Records a copy of `size` bytes of a buffer with BufferUsage::CopySource; VK_WHOLE_SIZE copies up to its
    // end.
    static Readback Record(CommandList& commands, const Buffer& source, uint64_t offset = 0,
                           uint64_t size = VK_WHOLE_SIZE);
    // Records a copy of a mip level of a layer of a texture with TextureUsage::CopySource, rows from the top,
    // tightly packed. All of the texture is in `layout` before and afterwards.
    static Readback Record(CommandList& commands, const Texture& source, VkImageLayout layout,
                           uint32_t mipLevel = 0, uint32_t layer = 0);

    // Sets the value that Device::Submit returned for the list.
    void SetSubmitted(uint64_t value) { m_value = value; }
    uint64_t Value() const { return m_value; }

    // Returns false before the submission has completed; never waits.
    bool IsReady() const;
    // Returns the bytes, which are valid while this object lives. Throws Error{Usage} if they are not ready.
    std::span<const std::byte> Bytes() const;
    // Waits until the bytes are ready. Throws Error{Usage} if the list was not submitted.
    std::span<const std::byte> Wait();

  private:
    Device* m_device = nullptr;
    Buffer m_staging;
    uint64_t m_value = 0;
};

// Submits and waits, for tests and for programs without other work. Errors are as above.
RAYGRAPH_API std::vector<std::byte> ReadBuffer(Device& device, const Buffer& source, uint64_t offset = 0,
                                               uint64_t size = VK_WHOLE_SIZE);
RAYGRAPH_API std::vector<std::byte> ReadTexture(Device& device, const Texture& source, VkImageLayout layout,
                                                uint32_t mipLevel = 0, uint32_t layer = 0);

}  // namespace raygraph::rhi
