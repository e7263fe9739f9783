// Radiance RGBE pictures, after the Radiance file-format notes (G. Ward, "Real Pixels", Graphics Gems II,
// 1991). A texel's channel is mantissa * 2^(exponent - 136); exponent 0 is black.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <new>

#include "base/files.h"
#include "base/text.h"
#include "renderer/image/decode.h"
#include "renderer/image/radiance_hdr.h"

namespace raygraph::image {
namespace {

using Rgbe = std::array<uint8_t, 4>;

// New run-length coding exists for these widths alone: its length field has 15 bits.
constexpr uint32_t kMinRleWidth = 8, kMaxRleWidth = 32767;
constexpr size_t kMaxHeaderBytes = 65536;

struct HdrReader {
    std::span<const std::byte> rest;
    std::string_view name;

    [[noreturn]] void Fail(const std::string& what) const { Reject(name, "HDR: " + what); }

    uint8_t Byte() {
        if (rest.empty()) Fail("the file is truncated");
        const auto value = static_cast<uint8_t>(rest.front());
        rest = rest.subspan(1);
        return value;
    }
    std::span<const std::byte> Take(size_t count) {
        if (count > rest.size()) Fail("the file is truncated");
        const auto taken = rest.first(count);
        rest = rest.subspan(count);
        return taken;
    }
    std::string_view Line() {
        const auto window = rest.first(std::min(rest.size(), kMaxHeaderBytes));
        const auto end = std::find(window.begin(), window.end(), std::byte{'\n'});
        if (end == window.end()) Fail("the header is truncated");
        const auto length = static_cast<size_t>(end - window.begin());
        const std::string_view line(reinterpret_cast<const char*>(rest.data()), length);
        rest = rest.subspan(length + 1);
        return line;
    }
};

struct Size {
    uint32_t width = 0, height = 0;
};

// Parses "-Y 512 +X 1024": rows from the top, texels from the left.
Size ParseResolution(const HdrReader& reader, std::string_view line) {
    const auto number = [&](std::string_view prefix, uint32_t& out) {
        if (!line.starts_with(prefix)) return false;
        line.remove_prefix(prefix.size());
        const auto [end, code] = std::from_chars(line.data(), line.data() + line.size(), out);
        line.remove_prefix(static_cast<size_t>(end - line.data()));
        return code == std::errc();
    };
    const std::string whole(line.substr(0, 60));
    Size size;
    if (!number("-Y ", size.height) || !number(" +X ", size.width) || !line.empty()) {
        reader.Fail("resolution '" + whole + "' is not of the form '-Y height +X width'");
    }
    return size;
}

// Returns EXPOSURE.
double ReadHeader(HdrReader& reader) {
    reader.Line();  // "#?RADIANCE" or another program's name
    double exposure = 1.0;
    for (std::string_view line = reader.Line(); !line.empty(); line = reader.Line()) {
        if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe") {
            reader.Fail('\'' + std::string(line.substr(0, 60)) + "' is not supported, only 32-bit_rle_rgbe");
        }
        constexpr std::string_view kExposure = "EXPOSURE=";
        if (line.starts_with(kExposure)) {
            line.remove_prefix(std::min(line.find_first_not_of(' ', kExposure.size()), line.size()));
            double factor = 1.0;
            std::from_chars(line.data(), line.data() + line.size(), factor);
            exposure *= factor;
        }
    }
    return exposure;
}

// Reads four planes of the row, each in runs (count + 128, value) and literals (count, values).
void ReadRleRow(HdrReader& reader, std::span<Rgbe> row) {
    for (size_t component = 0; component < 4; ++component) {
        for (size_t x = 0; x < row.size();) {
            const uint8_t code = reader.Byte();
            const size_t count = code > 128 ? code - 128u : code;
            if (count == 0 || count > row.size() - x) reader.Fail("a run exceeds its row");
            if (code > 128) {
                const uint8_t value = reader.Byte();
                for (size_t i = 0; i < count; ++i) row[x++][component] = value;
            } else {
                for (const std::byte value : reader.Take(count)) {
                    row[x++][component] = static_cast<uint8_t>(value);
                }
            }
        }
    }
}

// Reads texels one by one; (1, 1, 1, n) repeats the last one n times, each such code after another counting
// 256 times more.
void ReadFlatRow(HdrReader& reader, std::span<Rgbe> row) {
    uint32_t shift = 0;
    for (size_t x = 0; x < row.size();) {
        Rgbe texel;
        for (uint8_t& component : texel) component = reader.Byte();
        if (texel[0] != 1 || texel[1] != 1 || texel[2] != 1) {
            row[x++] = texel;
            shift = 0;
            continue;
        }
        if (x == 0) reader.Fail("a row starts with a run");
        const uint64_t count = shift < 32 ? uint64_t{texel[3]} << shift : 0;
        if (shift >= 32 || count > row.size() - x) reader.Fail("a run exceeds its row");
        std::fill_n(row.begin() + static_cast<ptrdiff_t>(x), count, row[x - 1]);
        x += count;
        shift += 8;
    }
}

void ReadRow(HdrReader& reader, std::span<Rgbe> row) {
    const auto& rest = reader.rest;
    const bool isRle = row.size() >= kMinRleWidth && row.size() <= kMaxRleWidth && rest.size() >= 4 &&
                       rest[0] == std::byte{2} && rest[1] == std::byte{2} && rest[2] < std::byte{128};
    if (!isRle) return ReadFlatRow(reader, row);
    const size_t length = std::to_integer<size_t>(rest[2]) << 8 | std::to_integer<size_t>(rest[3]);
    if (length != row.size()) {
        reader.Fail(Text("a row of {} texels in a picture {} wide", length, row.size()));
    }
    reader.Take(4);
    ReadRleRow(reader, row);
}

// Rounds to nearest; the largest channel's mantissa is 128 to 255.
Rgbe ToRgbe(const float* rgb) {
    constexpr double kMaxValue = 0x1.fep126;  // 255 * 2^(255 - 136)
    double channel[3];
    for (int c = 0; c < 3; ++c) {
        channel[c] = rgb[c] > 0.0f ? std::min(static_cast<double>(rgb[c]), kMaxValue) : 0.0;
    }
    const double maximum = std::max({channel[0], channel[1], channel[2]});
    int exponent = 0;
    if (maximum <= 0.0) return {0, 0, 0, 0};
    std::frexp(maximum, &exponent);
    if (std::ldexp(maximum, 8 - exponent) >= 255.5) ++exponent;
    if (exponent <= -128) return {0, 0, 0, 0};  // black, since it is below 2^-128
    Rgbe texel;
    for (int c = 0; c < 3; ++c) {
        texel[c] = static_cast<uint8_t>(std::lround(std::ldexp(channel[c], 8 - exponent)));
    }
    texel[3] = static_cast<uint8_t>(exponent + 128);
    return texel;
}

// Writes one plane of a row: runs of 4 to 127 equal bytes, everything else as literals of at most 128.
void AppendRlePlane(std::vector<std::byte>& out, std::span<const Rgbe> row, size_t component) {
    constexpr size_t kMinRun = 4, kMaxRun = 127, kMaxLiteral = 128;
    const auto runAt = [&](size_t x) {
        size_t end = x + 1;
        while (end < row.size() && end - x < kMaxRun && row[end][component] == row[x][component]) ++end;
        return end - x;
    };
    for (size_t x = 0; x < row.size();) {
        const size_t run = runAt(x);
        if (run >= kMinRun) {
            out.push_back(static_cast<std::byte>(128 + run));
            out.push_back(static_cast<std::byte>(row[x][component]));
            x += run;
            continue;
        }
        size_t end = x + run;
        while (end < row.size()) {
            const size_t next = runAt(end);
            if (next >= kMinRun) break;
            end += next;
        }
        while (x < end) {
            const size_t count = std::min(end - x, kMaxLiteral);
            out.push_back(static_cast<std::byte>(count));
            for (size_t i = 0; i < count; ++i) out.push_back(static_cast<std::byte>(row[x++][component]));
        }
    }
}

}  // namespace

float HdrExposure(std::span<const std::byte> bytes, std::string_view name) {
    HdrReader reader{bytes, name};
    return static_cast<float>(ReadHeader(reader));
}

ImageF DecodeHdr(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits,
                 std::vector<std::string>& warnings) {
    HdrReader reader{bytes, name};
    if (ReadHeader(reader) != 1.0)
        warnings.push_back(std::string(name) + ": EXPOSURE in the header is not applied");
    const auto [width, height] = ParseResolution(reader, reader.Line());
    CheckSize(name, width, height, limits);
    if (reader.rest.size() / 4 < height)
        reader.Fail("the file is truncated");  // a row takes at least so many bytes
    std::array<float, 256> scale = {};
    for (int exponent = 1; exponent < 256; ++exponent) scale[exponent] = std::ldexp(1.0f, exponent - 136);
    try {
        ImageF image{width, height, {}};
        // Memory is touched row by row, so a header that promises more than the file holds costs nothing.
        image.rgba.reserve(size_t{4} * width * height);
        std::vector<Rgbe> row(width);
        for (uint32_t y = 0; y < height; ++y) {
            ReadRow(reader, row);
            for (const Rgbe& texel : row) {
                const float unit = scale[texel[3]];
                image.rgba.insert(image.rgba.end(),
                                  {static_cast<float>(texel[0]) * unit, static_cast<float>(texel[1]) * unit,
                                   static_cast<float>(texel[2]) * unit, 1.0f});
            }
        }
        return image;
    } catch (const std::bad_alloc&) {
        RejectMemory(name, width, height);
    }
}

void WriteHdr(const std::filesystem::path& path, const ImageF& image) {
    CheckTexelCount(path, image.width, image.height, image.rgba.size());
    const bool isRle = image.width >= kMinRleWidth && image.width <= kMaxRleWidth;
    AtomicFile file(path);
    const std::string header =
        Text("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", image.height, image.width);
    file.Write(std::as_bytes(std::span(header)));
    std::vector<Rgbe> row(image.width);
    std::vector<std::byte> out;
    for (uint32_t y = 0; y < image.height; ++y) {
        const float* texels = image.rgba.data() + size_t{4} * image.width * y;
        for (uint32_t x = 0; x < image.width; ++x) row[x] = ToRgbe(texels + size_t{4} * x);
        if (!isRle) {
            file.Write(std::as_bytes(std::span(row)));
            continue;
        }
        out = {std::byte{2}, std::byte{2}, static_cast<std::byte>(image.width >> 8),
               static_cast<std::byte>(image.width & 255)};
        for (size_t component = 0; component < 4; ++component) AppendRlePlane(out, row, component);
        file.Write(out);
    }
    file.Commit();
}

}  // namespace raygraph::image
