// Private to renderer/image: checks an OpenEXR header before the library reads it.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "base/api.h"
#include "renderer/image/image.h"

namespace raygraph::image {

// OpenEXR allocates by the sizes in a header: attributes, tables of chunks, buffers for lines and tiles. This
// refuses (Error{BadInput}) every file whose header requests more than the file can hold or the limits allow,
// and unsupported pictures: multi-part, deep and subsampled ones. A file that passes may still be corrupt
// further on.
void CheckExrHeader(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits);

// Threads that code OpenEXR files, for programs. Threads: any.
//
//   const image::ExrThreads threads;
//   image::WriteExr(path, picture);

// While there is one, ReadExr and WriteExr use several threads of the OpenEXR library, which has one pool of
// them for the whole process. The first object starts them and the last one ends them; where the process has
// started some itself (Imf::setGlobalThreadCount), they are left alone. Files have the same bits with any
// number.
class RAYGRAPH_API ExrThreads {
  public:
    explicit ExrThreads(unsigned count = 0);  // 0: one a core
    ~ExrThreads();
    ExrThreads(const ExrThreads&) = delete;
    ExrThreads& operator=(const ExrThreads&) = delete;

  private:
    bool m_isCounted = false;
};

// Private to renderer/image: names for reading and writing OpenEXR.

// Attributes that the format itself defines: never written as attributes of a render, and not metadata
// when read.
inline bool IsFormatAttribute(std::string_view name) {
    constexpr std::array<std::string_view, 16> kNames = {
        "channels",           "chunkCount", "compression",       "dataWindow", "displayWindow", "envmap",
        "lineOrder",          "name",       "pixelAspectRatio",  "preview",    "tiles",         "type",
        "screenWindowCenter", "version",    "screenWindowWidth", "view"};
    return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

}  // namespace raygraph::image
