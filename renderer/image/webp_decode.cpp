#include <webp/decode.h>

#include <memory>
#include <new>

#include "base/text.h"
#include "renderer/image/decode.h"

namespace raygraph::image {
namespace {

const char* Reason(VP8StatusCode status) {
    switch (status) {
        case VP8_STATUS_UNSUPPORTED_FEATURE:
            return "unsupported feature";
        case VP8_STATUS_NOT_ENOUGH_DATA:
        case VP8_STATUS_SUSPENDED:
            return "the file is truncated";
        default:
            return "the file is corrupt";
    }
}

// For some damaged files, too, libwebp 1.5 reports that there is no memory for them.
bool HasMemoryFor(uint32_t width, uint32_t height) {
    constexpr size_t kBytesPerPixel = 16;  // above what libwebp takes
    const std::unique_ptr<std::byte[]> memory(new (std::nothrow) std::byte[kBytesPerPixel * width * height]);
    return memory != nullptr;
}

}  // namespace

Image8 DecodeWebp(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits) {
    const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
    const auto check = [&](VP8StatusCode status) {
        if (status != VP8_STATUS_OK) Reject(name, std::string("WebP: ") + Reason(status));
    };
    WebPDecoderConfig config;
    if (WebPInitDecoderConfig(&config) == 0) {
        throw MakeError(ErrorKind::Usage, "{}: libwebp at run time is not the one compiled for", name);
    }
    check(WebPGetFeatures(data, bytes.size(), &config.input));
    if (config.input.has_animation != 0) Reject(name, "WebP: animations are not supported");
    const auto width = static_cast<uint32_t>(config.input.width);
    const auto height = static_cast<uint32_t>(config.input.height);
    CheckSize(name, width, height, limits);
    // Decodes into the library's memory, which is only touched as far as the data goes; a vector would be
    // filled first.
    config.output.colorspace = MODE_RGBA;
    const std::unique_ptr<WebPDecBuffer, decltype(&WebPFreeDecBuffer)> output(&config.output,
                                                                              WebPFreeDecBuffer);
    const VP8StatusCode status = WebPDecode(data, bytes.size(), &config);
    if (status == VP8_STATUS_OUT_OF_MEMORY && !HasMemoryFor(width, height)) RejectMemory(name, width, height);
    check(status);
    try {
        const WebPRGBABuffer& texels = config.output.u.RGBA;
        Image8 image{width, height, {}};
        image.rgba.reserve(size_t{4} * width * height);
        for (uint32_t y = 0; y < height; ++y) {
            const uint8_t* row = texels.rgba + static_cast<ptrdiff_t>(y) * texels.stride;
            image.rgba.insert(image.rgba.end(), row, row + size_t{4} * width);
        }
        return image;
    } catch (const std::bad_alloc&) {
        RejectMemory(name, width, height);
    }
}

}  // namespace raygraph::image
