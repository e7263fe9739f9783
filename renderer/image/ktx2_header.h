// The header of a KTX2 file, after the KTX File Format Specification 2.0. Private to renderer/image. Threads:
// any.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "renderer/image/texels.h"

namespace raygraph::image {

enum class Supercompression : uint8_t { None = 0, BasisLz = 1, Zstd = 2 };

// Holds the fields of the data format descriptor of a file without a Vulkan format.
struct BasisFormat {
    bool isUastc = false;  // false: it is ETC1S
    bool isSrgb = false;
    bool hasSecondSlice = false;
    Swizzle channels = kIdentity;  // where the picture's channels are in what is decoded
};

struct Ktx2Header {
    uint32_t width = 0, height = 0;
    uint32_t levelCount = 1;
    uint32_t vkFormat = 0;  // 0: `basis` gives the format
    BasisFormat basis;
    Supercompression supercompression = Supercompression::None;
    std::span<const std::byte> level;  // the largest one, as stored
    uint64_t inflatedBytes = 0;        // its size without Zstandard, by the file
    struct StoredLevel {
        std::span<const std::byte> bytes;
        uint64_t inflatedBytes = 0;
    };
    std::vector<StoredLevel> smaller;  // the other levels, as far as they lie in the file
    std::span<const std::byte> global;
    // Is the swizzle that the file requests. It applies to the decoded channels, in place of
    // BasisFormat::channels.
    std::optional<Swizzle> swizzle;
};

// Reads the header of a 2D texture that is neither an array nor a cube map. Refuses all others, and data
// outside the file.
Ktx2Header ReadKtx2Header(std::span<const std::byte> bytes, std::string_view name,
                          const DecodeLimits& limits);

}  // namespace raygraph::image
