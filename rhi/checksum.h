// A checksum of bytes in files that are read back, and of what they are found by. For rhi/ alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace raygraph::rhi {

inline constexpr uint64_t kChecksumStart = 0xcbf29ce484222325ull;

// Returns the 64-bit FNV-1a checksum. For data in several parts, pass the checksum of the parts before as
// `before`.
inline uint64_t Checksum(std::span<const std::byte> bytes, uint64_t before = kChecksumStart) {
    uint64_t hash = before;
    for (const std::byte b : bytes) hash = (hash ^ static_cast<uint64_t>(b)) * 0x100000001b3ull;
    return hash;
}

}  // namespace raygraph::rhi
