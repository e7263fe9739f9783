#include "renderer/image/decode.h"

#include <algorithm>
#include <cmath>

#include "base/files.h"
#include "base/printable.h"
#include "base/text.h"

namespace raygraph::image {
namespace {

bool StartsWith(std::span<const std::byte> bytes, std::string_view magic, size_t offset = 0) {
    if (bytes.size() < offset + magic.size()) return false;
    return std::equal(magic.begin(), magic.end(), bytes.begin() + static_cast<ptrdiff_t>(offset),
                      [](char a, std::byte b) { return static_cast<std::byte>(a) == b; });
}

const char* FormatName(FileFormat format) {
    switch (format) {
        case FileFormat::Png:
            return "a PNG";
        case FileFormat::Jpeg:
            return "a JPEG";
        case FileFormat::Webp:
            return "a WebP";
        case FileFormat::Dds:
            return "a DDS";
        case FileFormat::Ktx2:
            return "a KTX2";
        case FileFormat::Hdr:
            return "a Radiance HDR";
        case FileFormat::Exr:
            return "an OpenEXR";
        case FileFormat::Unknown:
            break;
    }
    return "of an unknown format";
}

std::string PixelText(const ImageF& image, size_t index) {
    const size_t texel = index / 4;
    return Text("({}, {})", texel % image.width, texel / image.width);
}

void RequireFinite(const ImageF& image, std::string_view name) {
    for (size_t i = 0; i < image.rgba.size(); ++i) {
        const float value = image.rgba[i];
        if (!std::isfinite(value))
            Reject(name, Text("pixel {} is {}", PixelText(image, i), std::isnan(value) ? "NaN" : "infinite"));
    }
}

// Light is not negative, or it would poison every sample that meets it.
std::string ClampNegative(ImageF& image, std::string_view name) {
    uint64_t negativeCount = 0;
    for (float& value : image.rgba) {
        if (!(value < 0.0f)) continue;
        ++negativeCount;
        value = 0.0f;
    }
    if (negativeCount == 0) return {};
    return Text("{}: {} set to 0", name, Counted(negativeCount, "negative value", "negative values"));
}

}  // namespace

void Reject(std::string_view name, std::string_view what) {
    while (!what.empty() && (what.back() == '\n' || what.back() == '.')) what.remove_suffix(1);
    const std::string message = Printable(Text("{}: {}", name, what), 1024);
    throw Error(ErrorKind::BadInput, message);
}

std::string TruncationWarning(std::string_view name) {
    return Text("{}: the file is cut off behind its last pixel", name);
}

void RejectMemory(std::string_view name, uint64_t width, uint64_t height) {
    throw MakeError(ErrorKind::OutOfMemory, "{}: no memory for {} x {} pixels", name, width, height);
}

void CheckSize(std::string_view name, uint64_t width, uint64_t height, const DecodeLimits& limits) {
    const std::string size = Text("{} x {} pixels", width, height);
    if (width == 0 || height == 0) Reject(name, Text("{}: the picture is empty", size));
    if (width > limits.maxWidth || height > limits.maxHeight) {
        Reject(name, Text("{} exceed the limit of {} x {}", size, limits.maxWidth, limits.maxHeight));
    }
    if (width * height > limits.maxPixels) {
        Reject(name, Text("{} exceed the limit of {} pixels", size, limits.maxPixels));
    }
    if (limits.share && !limits.share->Take(width * height))
        Reject(name, Text("{} exceed what is left for all pictures", size));
}

void CheckTexelCount(const std::filesystem::path& path, uint64_t width, uint64_t height,
                     size_t texelNumbers) {
    if (width == 0 || height == 0 || texelNumbers != 4 * width * height) {
        throw MakeError(ErrorKind::Usage, "{}: cannot write {} x {} pixels from {} numbers", path, width,
                        height, texelNumbers);
    }
}

FileFormat SniffFormat(std::span<const std::byte> bytes) {
    if (StartsWith(bytes, "\x89PNG\r\n\x1a\n")) return FileFormat::Png;
    if (StartsWith(bytes, "\xff\xd8\xff")) return FileFormat::Jpeg;
    if (StartsWith(bytes, "RIFF") && StartsWith(bytes, "WEBP", 8)) return FileFormat::Webp;
    if (StartsWith(bytes, "DDS ")) return FileFormat::Dds;
    if (StartsWith(bytes, "\xabKTX 20\xbb\r\n\x1a\n")) return FileFormat::Ktx2;
    if (StartsWith(bytes, "#?")) return FileFormat::Hdr;
    if (StartsWith(bytes, "\x76\x2f\x31\x01")) return FileFormat::Exr;
    return FileFormat::Unknown;
}

Image8 DecodeImage8(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits) {
    if (bytes.empty()) Reject(name, "the file is empty");
    const FileFormat format = SniffFormat(bytes);
    switch (format) {
        case FileFormat::Png:
            return DecodePng(bytes, name, limits);
        case FileFormat::Jpeg:
            return DecodeJpeg(bytes, name, limits);
        case FileFormat::Webp:
            return DecodeWebp(bytes, name, limits);
        case FileFormat::Dds:
            return DecodeDds(bytes, name, limits);
        case FileFormat::Ktx2:
            return DecodeKtx2(bytes, name, limits);
        case FileFormat::Hdr:
        case FileFormat::Exr:
        case FileFormat::Unknown:
            break;
    }
    Reject(name, Text("is {}, not PNG, JPEG, WebP, DDS or KTX2", FormatName(format)));
}

Environment DecodeFloats(std::span<const std::byte> bytes, std::string_view name,
                         const DecodeLimits& limits) {
    if (bytes.empty()) Reject(name, "the file is empty");
    const FileFormat format = SniffFormat(bytes);
    Environment environment;
    if (format == FileFormat::Hdr) {
        environment.image = DecodeHdr(bytes, name, limits, environment.warnings);
    } else if (format == FileFormat::Exr) {
        environment.image = DecodeExrColor(bytes, name, limits);
    } else {
        Reject(name, Text("is {}; an environment is Radiance HDR or OpenEXR", FormatName(format)));
    }
    return environment;
}

Environment DecodeEnvironment(std::span<const std::byte> bytes, std::string_view name,
                              const DecodeLimits& limits) {
    Environment environment = DecodeFloats(bytes, name, limits);
    RequireFinite(environment.image, name);
    environment.note = ClampNegative(environment.image, name);
    return environment;
}

Environment ReadEnvironment(const std::filesystem::path& path, const DecodeLimits& limits) {
    return DecodeEnvironment(ReadFile(path), Text("{}", path), limits);
}

}  // namespace raygraph::image
