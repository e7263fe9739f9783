// Multichannel OpenEXR: how a render is stored with its AOVs, variance and settings, and read back exactly
// for resuming and merging. Error and threading contract as in renderer/image/image.h.
// Threads: any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/api.h"
#include "renderer/image/image.h"

namespace raygraph::image {

// The value of an attribute. EXR has no 64-bit integer: such a number (a seed) is stored as its decimal
// string.
using ExrAttribute = std::variant<int32_t, float, double, std::string>;
using ExrAttributes = std::map<std::string, ExrAttribute, std::less<>>;

// Holds one channel: one number a pixel, rows from the top.
struct ExrChannel {
    std::string name;  // "R", "albedo.R", "id.instance", ...
    std::variant<std::vector<float>, std::vector<uint32_t>> samples;
};

// Says of which picture (its display window) the pixels of a file are a part, and where they are in it (its
// data window).
struct ExrWindow {
    int32_t x = 0, y = 0;                          // the first pixel, from the picture's upper left corner
    uint32_t pictureWidth = 0, pictureHeight = 0;  // when writing, 0: there are no other pixels

    bool operator==(const ExrWindow&) const = default;
};

struct RAYGRAPH_API ExrImage {
    uint32_t width = 0, height = 0;
    std::vector<ExrChannel> channels;  // sorted by name when they were read
    ExrAttributes attributes;
    ExrWindow window{};

    // Returns the samples of the channel of this name; nullptr when there is none or it is of the other type.
    const std::vector<float>* FloatChannel(std::string_view channelName) const;
    const std::vector<uint32_t>* UintChannel(std::string_view channelName) const;
};

// Refers to a channel to write: sample (x, y) is at first[(y * width + x) * stride]. It owns nothing. So
// {"albedo.G", std::span<const float>(rgba).subspan(1), 4} is the green of an RGBA buffer.
struct ExrPlane {
    std::string name;
    std::variant<std::span<const float>, std::span<const uint32_t>> samples;
    uint32_t stride = 1;  // in samples
    bool isHalf = false;  // for floats: stored as half floats, at most +-65504
};

// Reads all channels of a single-part file with all int, float, double and string attributes that are not
// part of the format itself. float32 and uint32 come back bit for bit (NaN included), half is widened to
// float. Subsampled channels, deep and multi-part files are refused.
RAYGRAPH_API ExrImage ReadExr(const std::filesystem::path& path,
                              const DecodeLimits& limits = kEnvironmentLimits);
RAYGRAPH_API ExrImage DecodeExr(std::span<const std::byte> bytes, std::string_view name,
                                const DecodeLimits& limits = kEnvironmentLimits);

// Writes scan lines with ZIP. Throws Error{Usage} for a plane too short for the picture, an empty or repeated
// channel name, or an attribute whose name the format itself uses ("channels", "dataWindow", ...). Returns
// how many samples of half planes were beyond their range.
RAYGRAPH_API uint64_t WriteExr(const std::filesystem::path& path, uint32_t width, uint32_t height,
                               std::span<const ExrPlane> planes, const ExrAttributes& attributes = {},
                               const ExrWindow& window = {});
RAYGRAPH_API void WriteExr(const std::filesystem::path& path, const ExrImage& image);

// ExrThreads: threads that code OpenEXR files.
//
//   const image::ExrThreads threads;
//   image::WriteExr(path, picture);
//
// While there is one, ReadExr and WriteExr use several threads of the OpenEXR library, which has one pool of
// them for the whole process. The first object starts them and the last one ends them; where the process has
// started some itself (Imf::setGlobalThreadCount), they are left alone. Files have the same bits with any
// number.
class RAYGRAPH_API ExrThreads {
  public:
    explicit ExrThreads(unsigned count = 0);  // 0: one per core
    ~ExrThreads();
    ExrThreads(const ExrThreads&) = delete;
    ExrThreads& operator=(const ExrThreads&) = delete;

  private:
    bool m_isCounted = false;
};

}  // namespace raygraph::image
