// Fuzzes pictures: textures as the importer decodes them, environments and multichannel renders.
#include <cmath>

#include "renderer/image/exr.h"
#include "renderer/image/image.h"
#include "tests/fuzz/target.h"

namespace raygraph::fuzz {

namespace {

constexpr image::DecodeLimits kLimits{.maxWidth = 256, .maxHeight = 256, .maxPixels = 1 << 14};
constexpr const char* kName = "file";

void RequireSize(uint32_t width, uint32_t height, size_t numbers, size_t perPixel) {
    Require(width > 0 && height > 0, "an empty picture");
    Require(width <= kLimits.maxWidth && height <= kLimits.maxHeight &&
                uint64_t{width} * height <= kLimits.maxPixels,
            "a picture beyond the limits");
    Require(numbers == perPixel * width * height, "a picture with other than its texels");
}

}  // namespace

void RunImages(Input input) {
    Succeeds("file: ", {ErrorKind::BadInput}, [&] {
        const image::Image8 image = image::DecodeImage8(input, kName, kLimits);
        RequireSize(image.width, image.height, image.rgba.size(), 4);
    });
}

void RunEnvironment(Input input) {
    Succeeds("file: ", {ErrorKind::BadInput}, [&] {
        const image::Environment environment = image::DecodeEnvironment(input, kName, kLimits);
        const image::ImageF& image = environment.image;
        RequireSize(image.width, image.height, image.rgba.size(), 4);
        for (const float value : image.rgba)
            Require(std::isfinite(value) && value >= 0.0f, "a value that is no radiance");
    });
    Succeeds("file: ", {ErrorKind::BadInput}, [&] {
        const image::ExrImage image = image::DecodeExr(input, kName, kLimits);
        Require(!image.channels.empty(), "no channels");
        for (const image::ExrChannel& channel : image.channels)
            std::visit(
                [&](const auto& samples) { RequireSize(image.width, image.height, samples.size(), 1); },
                channel.samples);
    });
}

}  // namespace raygraph::fuzz
