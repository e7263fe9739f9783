// Pictures in and out of files: 8-bit textures, environment maps, finished renders. For multichannel OpenEXR
// see renderer/image/exr.h.
//
// Input is hostile: the size that a file claims is checked against the limits before anything of that size
// is allocated, and every failure is one Error{BadInput} of one line that starts with the file's name
// (Error{Io} when the file cannot be read, Error{OutOfMemory} when memory runs out). Threads: every function
// may be called from any; nothing here has global state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "renderer/image/pixel_budget.h"

namespace raygraph::image {

// Names the coding of texels in blocks of 4 x 4, as GPUs read them.
enum class BlockCoding : uint8_t { None, Bc1Opaque, Bc1, Bc2, Bc3, Bc4, Bc5, Bc7 };

// Holds a picture as its file has it: blocks row by row, from the largest level on, each half the one before,
// rounded down, at least one texel. Decoded, a block has the texels of Image8.
struct BlockLevels {
    BlockCoding coding = BlockCoding::None;
    std::vector<std::vector<std::byte>> levels;

    bool IsEmpty() const { return levels.empty(); }
};
// Returns the bytes of a level of so many texels.
RAYGRAPH_API uint64_t BlockBytes(BlockCoding coding, uint32_t width, uint32_t height);

// Holds a picture of eight bits a channel, RGBA, rows from the top, no padding: rgba.size() == 4 * width *
// height. The numbers are those of the file: only the user knows whether they are sRGB or linear. Alpha is
// not premultiplied.
struct Image8 {
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> rgba;
    BlockLevels blocks = {};  // the source of the texels, if that is blocks that GPUs read
    // Decoding sets these: defects of the file that leave the picture complete. Each is one line that starts
    // with the file's name.
    std::vector<std::string> warnings = {};
};

// Holds a picture of linear float32, RGBA, rows from the top, no padding: rgba.size() == 4 * width * height.
struct ImageF {
    uint32_t width = 0, height = 0;
    std::vector<float> rgba;
};

// Limits a decoder's allocations. A picture beyond any of them is refused by its header.
struct DecodeLimits {
    uint32_t maxWidth = 16384, maxHeight = 16384;
    uint64_t maxPixels = uint64_t{1} << 28;  // width * height
    // Is the budget of several pictures that are decoded at once; nullptr: no common limit.
    PixelBudget::Share* share = nullptr;
};
// An environment has four times the bytes of a texture: 16384 x 8192 is 2 GiB.
inline constexpr DecodeLimits kEnvironmentLimits{.maxPixels = uint64_t{1} << 27};

enum class FileFormat : uint8_t { Unknown, Png, Jpeg, Webp, Dds, Ktx2, Hdr, Exr };

// Returns the format by its first bytes; names and extensions are ignored.
RAYGRAPH_API FileFormat SniffFormat(std::span<const std::byte> bytes);

// Decodes PNG, JPEG, WebP, DDS or KTX2, as SniffFormat() says. `name` is for error messages. Color profiles,
// gamma chunks, EXIF orientation and whether a texel format is one of sRGB are ignored, as glTF asks. Gray
// becomes R = G = B, missing alpha 255, 16-bit PNG is rounded to 8, CMYK JPEG is converted by the plain
// formula (no profile). Of textures with levels the largest is decoded, and blocks are kept as far as their
// levels are there and whole; channels that a format of one or two lacks are 0. A truncated or corrupt file
// is an error even where the decoder could invent the rest; a PNG or a JPEG that has all texels may lack its
// end, with a warning. Animated WebP, cube maps, arrays, volumes and premultiplied alpha are errors.
RAYGRAPH_API Image8 DecodeImage8(std::span<const std::byte> bytes, std::string_view name,
                                 const DecodeLimits& limits = {});

struct Environment {
    ImageF image;                       // alpha is 1 where the file has none
    std::vector<std::string> warnings;  // one line each, starting with the file's name
    std::string note;                   // likewise, for information: values that were clamped; "": none
};

// Reads Radiance .hdr (RGBE; flat, old and new run-length coding; `-Y H +X W` only) or OpenEXR (single part,
// scan lines or tiles, any compression; R G B [A], or Y; half, float or uint), by content. Values stay as in
// the file, also above 65504. A NaN or an infinity is an error that names the pixel; a negative value, as
// resampling leaves some, becomes 0 with a note. An EXR's picture is its display window, black outside the
// data window; with an envmap attribute it is the data window. Chromaticities other than those of Rec. 709
// are converted to Rec. 709, white to white.
RAYGRAPH_API Environment ReadEnvironment(const std::filesystem::path& path,
                                         const DecodeLimits& limits = kEnvironmentLimits);
RAYGRAPH_API Environment DecodeEnvironment(std::span<const std::byte> bytes, std::string_view name,
                                           const DecodeLimits& limits = kEnvironmentLimits);
// Does the same for a picture that need not be light: negative values, NaN, infinities stay.
RAYGRAPH_API Environment DecodeFloats(std::span<const std::byte> bytes, std::string_view name,
                                      const DecodeLimits& limits = kEnvironmentLimits);

// The writers replace the file as a whole or leave the old one unchanged (base/files.h). They throw
// Error{Io} naming the path, and Error{Usage} for a picture whose size and texels do not agree or that the
// format cannot hold.

// Returns an 8-bit PNG marked sRGB (the texels must be so encoded), without alpha if all texels are opaque.
// Throws as the writers do; `name` is for messages.
RAYGRAPH_API std::vector<std::byte> EncodePng(const Image8& image, std::string_view name);
RAYGRAPH_API void WritePng(const std::filesystem::path& path, const Image8& image);

// Writes a baseline JPEG of quality 92, with colors at full resolution; alpha is dropped.
RAYGRAPH_API void WriteJpeg(const std::filesystem::path& path, const Image8& image);

// Writes Radiance RGBE, run-length coded, rounded to the nearest; alpha is dropped. NaN and negative values
// become 0, values beyond the format its greatest.
RAYGRAPH_API void WriteHdr(const std::filesystem::path& path, const ImageF& image);

}  // namespace raygraph::image
