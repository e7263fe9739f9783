// The vertex streams of one group, packed one after another into one buffer. Threads: as std::vector.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "base/large_pages.h"
#include "rhi/shader_binding_table.h"
#include "rhi/vulkan.h"

namespace raygraph {

inline constexpr uint64_t kStreamAlignment = 16;
constexpr uint64_t AlignStream(uint64_t bytes) {
    return rhi::AlignUp(bytes, kStreamAlignment);
}

// Collects the streams of one group, then uploads them into one buffer. Until the upload, the addresses are
// offsets, or kAbsent.
class StreamPacker {
  public:
    static constexpr uint64_t kAbsent = ~uint64_t{0};

    template <typename T>
    uint64_t Append(const std::vector<T>& values) {
        if (values.empty()) return kAbsent;
        const uint64_t offset = AlignStream(m_bytes.size());
        m_bytes.resize(offset + values.size() * sizeof(T));
        std::memcpy(m_bytes.data() + offset, values.data(), values.size() * sizeof(T));
        return offset;
    }
    std::span<const std::byte> Bytes() const { return m_bytes; }
    std::span<std::byte> At(uint64_t offset) { return std::span(m_bytes).subspan(offset); }

    // Turns an offset into an address, shifted so that element `first` of the group's numbering is the first
    // of the stream.
    static uint64_t Address(uint64_t offset, VkDeviceAddress base, uint64_t first = 0,
                            uint64_t elementBytes = 0) {
        return offset == kAbsent ? 0 : base + offset - first * elementBytes;
    }

  private:
    // Memory that is returned to the system without a lock that blocks other threads.
    LargeArray<std::byte> m_bytes;
};

}  // namespace raygraph
