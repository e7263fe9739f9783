#include <webp/decode.h>

#include <new>

#include "base/error.h"
#include "renderer/image/decode.h"

namespace raygraph::image {
namespace {

const char* Reason(VP8StatusCode status) {
    switch (status) {
        case VP8_STATUS_OUT_OF_MEMORY:
            return "out of memory";
        case VP8_STATUS_UNSUPPORTED_FEATURE:
            return "unsupported feature";
        case VP8_STATUS_NOT_ENOUGH_DATA:
        case VP8_STATUS_SUSPENDED:
            return "the file is truncated";
        default:
            return "the file is corrupt";
    }
}

}  // namespace

Image8 DecodeWebp(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits) {
    const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
    const auto check = [&](VP8StatusCode status) {
        if (status != VP8_STATUS_OK) Refuse(name, std::string("WebP: ") + Reason(status));
    };
    WebPDecoderConfig config;
    if (WebPInitDecoderConfig(&config) == 0) {
        throw Error(ErrorKind::Usage,
                    std::string(name) + ": libwebp at run time is not the one compiled for");
    }
    check(WebPGetFeatures(data, bytes.size(), &config.input));
    if (config.input.has_animation != 0) Refuse(name, "WebP: animations are not supported");
    const auto width = static_cast<uint32_t>(config.input.width);
    const auto height = static_cast<uint32_t>(config.input.height);
    CheckSize(name, width, height, limits);
    try {
        Image8 image{width, height, std::vector<uint8_t>(size_t{4} * width * height)};
        config.output.colorspace = MODE_RGBA;
        config.output.is_external_memory = 1;
        config.output.u.RGBA = {image.rgba.data(), static_cast<int>(4 * width), image.rgba.size()};
        check(WebPDecode(data, bytes.size(), &config));
        return image;
    } catch (const std::bad_alloc&) {
        RefuseMemory(name, width, height);
    }
}

}  // namespace raygraph::image
