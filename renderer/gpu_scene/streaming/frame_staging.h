// Mapped memory for what a frame uploads, used again as soon as the device has read it: a frame in which a
// few records change does not wait for the allocator or the kernel. Threads: as the Renderer.
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

    // At least so many bytes, to be copied from or read by shaders; the reference is valid until the next
    // call. What was taken and not submitted is taken again.
    const rhi::Buffer& Take(uint64_t bytes);
    // What was taken last is read by what has been submitted by now.
    void MarkSubmitted();

  private:
    struct Block {
        rhi::Buffer buffer;
        uint64_t until = 0;  // of the timeline: in use till then
    };
    rhi::Device* m_device = nullptr;
    std::string m_name;
    std::vector<Block> m_blocks;  // one a frame in flight
    size_t m_taken = 0;
};

}  // namespace raygraph
