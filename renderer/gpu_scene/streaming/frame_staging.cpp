#include "renderer/gpu_scene/streaming/frame_staging.h"

#include <algorithm>
#include <bit>

namespace raygraph {

const rhi::Buffer& FrameStaging::Take(uint64_t bytes) {
    const uint64_t completed = m_device->CompletedValue();
    const auto free = std::ranges::find_if(m_blocks, [&](const Block& b) { return b.until <= completed; });
    m_taken = static_cast<size_t>(free - m_blocks.begin());
    if (free == m_blocks.end()) m_blocks.emplace_back();
    Block& block = m_blocks[m_taken];
    if (!block.buffer || block.buffer.Size() < bytes)
        block.buffer =
            m_device->CreateBuffer({.name = m_name,
                                    .size = std::bit_ceil(bytes),
                                    .usage = rhi::BufferUsage::CopySource | rhi::BufferUsage::Storage,
                                    .memory = rhi::MemoryKind::Upload});
    return block.buffer;
}

void FrameStaging::MarkSubmitted() {
    m_blocks[m_taken].until = m_device->LastSubmittedValue();
}

}  // namespace raygraph
