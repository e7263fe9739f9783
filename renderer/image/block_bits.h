// A reader of the bits of block-compressed textures. Private to renderer/image.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace raygraph::image {

// A number of so many bytes, the lowest first. The caller has checked that they are there.
inline uint64_t Little(std::span<const std::byte> bytes, size_t at, size_t count) {
    uint64_t value = 0;
    for (size_t i = 0; i < count; ++i) value |= std::to_integer<uint64_t>(bytes[at + i]) << (8 * i);
    return value;
}
inline uint32_t Little32(std::span<const std::byte> bytes, size_t at) {
    return static_cast<uint32_t>(Little(bytes, at, 4));
}

// RGBA of 4 x 4 texels, 8 bits a channel, rows from the top.
using BlockTexels = std::array<uint8_t, 64>;

// The 128 bits of a block, taken from the lowest upwards.
class BlockBits {
  public:
    explicit BlockBits(std::span<const std::byte, 16> block)
        : m_low(Little(block, 0, 8)), m_high(Little(block, 8, 8)) {}

    // The next 0 to 32 bits.
    uint32_t Take(unsigned count) {
        if (count == 0) return 0;
        const auto value = static_cast<uint32_t>(m_low & ((uint64_t{1} << count) - 1));
        m_low = m_low >> count | m_high << (64 - count);
        m_high >>= count;
        return value;
    }

  private:
    uint64_t m_low, m_high;
};

}  // namespace raygraph::image
