#include "renderer/image/exr_header.h"

#include "base/text.h"

#include <OpenEXR/ImfVersion.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <set>
#include <string>

#include "renderer/image/decode.h"

namespace raygraph::image {
namespace {

// Scan lines in a chunk (openexr.com, "OpenEXR File Layout"), by compression method: none, RLE, ZIPS, ZIP,
// PIZ, PXR24, B44, B44A, DWAA, DWAB.
constexpr std::array<uint32_t, 10> kLinesPerChunk = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
// All channels together, padded to whole chunks or tiles: 4 GiB of float32.
constexpr uint64_t kMaxSampleCount = uint64_t{1} << 30;
constexpr uint64_t kMaxPaddedPixelCount = uint64_t{1} << 24;
constexpr int64_t kMaxCoordinate = int64_t{1} << 29;

// Bytes of the types that OpenEXR reads by their own size, whatever size the file gives. With another one,
// what the library takes for the next attribute would not be what is checked here.
struct TypeSize {
    std::string_view type;
    size_t bytes;
};
constexpr std::array<TypeSize, 24> kTypeSizes{{{"box2f", 16},
                                               {"box2i", 16},
                                               {"chromaticities", 32},
                                               {"compression", 1},
                                               {"deepImageState", 1},
                                               {"double", 8},
                                               {"envmap", 1},
                                               {"float", 4},
                                               {"int", 4},
                                               {"keycode", 28},
                                               {"m33d", 72},
                                               {"m33f", 36},
                                               {"m44d", 128},
                                               {"m44f", 64},
                                               {"lineOrder", 1},
                                               {"v2d", 16},
                                               {"rational", 8},
                                               {"tiledesc", 9},
                                               {"timecode", 8},
                                               {"v2f", 8},
                                               {"v2i", 8},
                                               {"v3d", 24},
                                               {"v3f", 12},
                                               {"v3i", 12}}};

struct Window {
    uint64_t width = 0, height = 0;
};
struct Tiles {
    uint64_t width = 0, height = 0;
};

class ExrHeaderCheck {
  public:
    ExrHeaderCheck(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits)
        : m_rest(bytes), m_name(name), m_limits(limits) {}

    void Run() {
        ReadVersion();
        while (!m_rest.empty() && m_rest.front() != std::byte{0}) ReadAttribute();
        Take(1, "the header");
        Conclude();
    }

  private:
    template <typename... Values>
    [[noreturn]] void Fail(fmt::format_string<Values...> format, Values&&... values) const {
        Refuse(m_name, Text("EXR: {}", Text(format, std::forward<Values>(values)...)));
    }

    std::span<const std::byte> Take(size_t count, const std::string& what) {
        if (count > m_rest.size()) Fail("{} is truncated", what);
        const auto taken = m_rest.first(count);
        m_rest = m_rest.subspan(count);
        return taken;
    }
    static int32_t Int(std::span<const std::byte> bytes, size_t offset) {
        uint32_t value = 0;
        for (size_t i = 0; i < 4; ++i) value |= std::to_integer<uint32_t>(bytes[offset + i]) << (8 * i);
        return static_cast<int32_t>(value);
    }
    // A string that ends with a zero.
    std::string ReadText(std::span<const std::byte>& bytes, const std::string& what) const {
        constexpr size_t kMaxLength = 255;  // With the long-names flag; OpenEXR itself holds to 31 without.
        const auto window = bytes.first(std::min(bytes.size(), kMaxLength + 1));
        const auto end = std::find(window.begin(), window.end(), std::byte{0});
        if (end == window.end()) Fail("{} is too long or truncated", what);
        const auto length = static_cast<size_t>(end - window.begin());
        std::string text(reinterpret_cast<const char*>(bytes.data()), length);
        bytes = bytes.subspan(length + 1);
        return text;
    }

    void ReadVersion() {
        const auto head = Take(8, "the header");
        const int32_t version = Int(head, 4);
        if ((version & 0xff) != Imf::EXR_VERSION || !Imf::supportsFlags(Imf::getFlags(version))) {
            Fail("version field {} is not supported", version);
        }
        if (Imf::isMultiPart(version)) Fail("multi-part files are not supported");
        if (Imf::isNonImage(version)) Fail("deep pictures are not supported");
        m_isTiled = Imf::isTiled(version);
    }

    void ReadAttribute() {
        const std::string attribute = ReadText(m_rest, "an attribute's name");
        const std::string type = ReadText(m_rest, Text("the type of attribute '{}'", attribute));
        const std::string named = Text("attribute '{}'", attribute);
        const int32_t size = Int(Take(4, named), 0);
        if (size < 0) Fail("{} has negative size", named);
        const auto value = Take(static_cast<size_t>(size), named);
        if (!m_seen.insert(attribute).second) Fail("{} is there twice", named);
        if (!HasValidSize(type, value))
            Fail("{} has {} bytes, which a {} of its content has not", named, size, type);
        const auto expect = [&](const char* expectedType, size_t expectedSize) {
            if (type == expectedType && value.size() == expectedSize) return;
            Fail("{} is not a {}", named, expectedType);
        };
        if (attribute == "channels") {
            if (type != "chlist") Fail("attribute 'channels' is not a chlist");
            ReadChannels(value);
        } else if (type == "chlist") {
            Fail("{} is a second list of channels", named);
        } else if (attribute == "compression") {
            expect("compression", 1);
            const auto method = std::to_integer<size_t>(value[0]);
            if (method >= kLinesPerChunk.size()) Fail("compression {} is unknown", method);
            m_linesPerChunk = kLinesPerChunk[method];
        } else if (attribute == "dataWindow") {
            expect("box2i", 16);
            ReadDataWindow(value);
        } else if (attribute == "tiles") {
            expect("tiledesc", 9);
            m_tiles = Tiles{static_cast<uint32_t>(Int(value, 0)), static_cast<uint32_t>(Int(value, 4))};
        } else if (attribute == "type" && value.size() >= 4 && std::memcmp(value.data(), "deep", 4) == 0) {
            Fail("deep pictures are not supported");
        }
    }

    // Returns whether OpenEXR, by what the type says, reads all of the value and no more.
    static bool HasValidSize(std::string_view type, std::span<const std::byte> value) {
        for (const TypeSize& known : kTypeSizes)
            if (known.type == type) return value.size() == known.bytes;
        if (type == "floatvector") return value.size() % 4 == 0;
        if (type == "preview") {  // its width and height, four bytes a pixel
            if (value.size() < 8) return false;
            const int64_t width = Int(value, 0), height = Int(value, 4), pixels = width * height;
            return width >= 0 && height >= 0 && pixels <= INT32_MAX &&
                   value.size() - 8 == 4 * static_cast<uint64_t>(pixels);
        }
        if (type == "stringvector") {  // texts, each after its length
            while (value.size() >= 4) {
                const int64_t length = Int(value, 0);
                if (length < 0 || static_cast<uint64_t>(length) > value.size() - 4) return false;
                value = value.subspan(4 + static_cast<size_t>(length));
            }
            return value.empty();
        }
        return true;
    }

    void ReadChannels(std::span<const std::byte> list) {
        constexpr size_t kEntryBytes = 16;  // Type, linearity and padding, two samplings.
        while (!list.empty() && list.front() != std::byte{0}) {
            const std::string channel = ReadText(list, "a channel's name");
            if (list.size() < kEntryBytes) Fail("channel '{}' is truncated", channel);
            if (Int(list, 8) != 1 || Int(list, 12) != 1) {
                Fail("channel '{}' is subsampled, which is not supported", channel);
            }
            list = list.subspan(kEntryBytes);
            ++m_channelCount;
        }
        if (list.size() != 1) Fail("the list of channels does not end where it should");
        if (m_channelCount == 0) Fail("there are no channels");
    }

    void ReadDataWindow(std::span<const std::byte> box) {
        const int64_t minX = Int(box, 0), minY = Int(box, 4), maxX = Int(box, 8), maxY = Int(box, 12);
        const std::string text = Text("({}, {}) to ({}, {})", minX, minY, maxX, maxY);
        if (maxX < minX || maxY < minY) Fail("data window {} is empty", text);
        if (std::min(minX, minY) < -kMaxCoordinate || std::max(maxX, maxY) > kMaxCoordinate) {
            Fail("data window {} is too far out", text);
        }
        m_window = Window{static_cast<uint64_t>(maxX - minX + 1), static_cast<uint64_t>(maxY - minY + 1)};
        CheckSize(m_name, m_window->width, m_window->height, m_limits);
    }

    void Conclude() {
        if (m_channelCount == 0 || !m_window || !m_linesPerChunk || (m_isTiled && !m_tiles)) {
            Fail("a required attribute is missing");
        }
        if (m_isTiled && (m_tiles->width == 0 || m_tiles->height == 0)) Fail("the tiles are empty");
        const uint64_t chunkWidth = m_isTiled ? m_tiles->width : m_window->width;
        const uint64_t chunkHeight = m_isTiled ? m_tiles->height : *m_linesPerChunk;
        const uint64_t columns = (m_window->width + chunkWidth - 1) / chunkWidth;
        const uint64_t rows = (m_window->height + chunkHeight - 1) / chunkHeight;
        // 32-bit factors: the products of two fit.
        const uint64_t paddedPixels = columns * chunkWidth * rows * chunkHeight;
        const bool isTooWide = std::max(columns * chunkWidth, rows * chunkHeight) > UINT32_MAX;
        if (isTooWide || paddedPixels > std::max(m_limits.maxPixels, kMaxPaddedPixelCount)) {
            Fail("chunks of {} x {} pixels exceed the limit", chunkWidth, chunkHeight);
        }
        if (m_channelCount > kMaxSampleCount / paddedPixels) {
            Fail("{} channels of {} x {} pixels exceed the limit", m_channelCount, m_window->width,
                 m_window->height);
        }
        // The table of offsets that follows has eight bytes a chunk (more with mip levels).
        if (columns * rows > m_rest.size() / 8) Fail("the file is truncated");
    }

    std::span<const std::byte> m_rest;
    std::string_view m_name;
    DecodeLimits m_limits;
    bool m_isTiled = false;
    uint64_t m_channelCount = 0;
    std::optional<Window> m_window;
    std::optional<Tiles> m_tiles;
    std::optional<uint32_t> m_linesPerChunk;
    std::set<std::string> m_seen;
};

}  // namespace

void CheckExrHeader(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits) {
    ExrHeaderCheck(bytes, name, limits).Run();
}

}  // namespace raygraph::image
