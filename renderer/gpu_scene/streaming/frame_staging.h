// Mapped memory for the uploads of a frame, which is reused as soon as the device has read it: a frame in
// which a few records change waits neither for the allocator nor for the kernel. Threads: that of the
// Renderer.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rhi/device.h"
#include "rhi/resources.h"

namespace raygraph {

class FrameStaging {
  public:
    FrameStaging() = default;
    FrameStaging(rhi::Device& device, std::string name) : m_device(&device), m_name(std::move(name)) {}

    // Returns a buffer of at least `bytes`, from which copies and shaders read; the reference is valid until
    // the next call. A buffer that was taken and not submitted is returned again.
    const rhi::Buffer& Take(uint64_t bytes);
    // The buffer that was taken last is read by work that has been submitted by now.
    void MarkSubmitted();

  private:
    struct Block {
        rhi::Buffer buffer;
        uint64_t until = 0;  // timeline value until which the buffer is in use
    };
    rhi::Device* m_device = nullptr;
    std::string m_name;
    std::vector<Block> m_blocks;  // one per frame in flight
    size_t m_taken = 0;
};

}  // namespace raygraph
