#include "renderer/image/exr_read.h"

#include <OpenEXR/Iex.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>
#include <OpenEXR/ImfVersion.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "base/files.h"
#include "base/text.h"
#include "renderer/image/decode.h"
#include "renderer/image/exr.h"

namespace raygraph::image {
namespace {

class MemoryStream final : public Imf::IStream {
  public:
    MemoryStream(std::span<const std::byte> bytes, const char* name) : IStream(name), m_bytes(bytes) {}

    // The interface requires the result false when this read reached the end of the file.
    bool read(char out[], int count) override {
        const auto size = static_cast<uint64_t>(std::max(count, 0));
        if (size > m_bytes.size() - m_position) throw Iex::InputExc("the file is truncated");
        std::memcpy(out, m_bytes.data() + m_position, size);
        m_position += size;
        return m_position < m_bytes.size();
    }
    uint64_t tellg() override { return m_position; }
    void seekg(uint64_t position) override {
        if (position > m_bytes.size()) throw Iex::InputExc("an offset points beyond the end");
        m_position = position;
    }

  private:
    std::span<const std::byte> m_bytes;
    uint64_t m_position = 0;
};

// ExrReader is an open file whose header has passed CheckExrHeader().
class ExrReader {
  public:
    ExrReader(std::span<const std::byte> bytes, std::string_view name)
        : m_stream(bytes, std::string(name).c_str()), m_file(m_stream) {}

    const Imf::Header& Header() const { return m_file.header(); }
    uint32_t Width() const { return Extent(Window().min.x, Window().max.x); }
    uint32_t Height() const { return Extent(Window().min.y, Window().max.y); }
    uint64_t PixelCount() const { return uint64_t{Width()} * Height(); }

    ExrWindow WindowInPicture() const {
        const Imath::Box2i &data = Window(), &picture = m_file.header().displayWindow();
        return {data.min.x - picture.min.x, data.min.y - picture.min.y, Extent(picture.min.x, picture.max.x),
                Extent(picture.min.y, picture.max.y)};
    }

    // Adds a channel to be read to first[(y * Width() + x) * stride]; numbers have 4 bytes.
    void Add(const std::string& channel, Imf::PixelType type, void* first, size_t stride = 1) {
        const size_t step = stride * 4;
        m_frame.insert(channel, Imf::Slice::Make(type, first, Window(), step, step * Width()));
    }

    // Reads the added channels band by band from the top; growTo(pixelCount) comes before each band, so that
    // memory is touched no further than the file's data goes.
    template <typename GrowTo>
    void Read(const GrowTo& growTo) {
        m_file.setFrameBuffer(m_frame);
        // A band is whole chunks; tiles, of any height, come all at once.
        const uint32_t band = Header().hasTileDescription() ? Height() : 256;
        for (uint32_t y = 0; y < Height(); y += band) {
            const uint32_t end = std::min(y + band, Height());
            growTo(size_t{Width()} * end);
            m_file.readPixels(Window().min.y + static_cast<int>(y),
                              Window().min.y + static_cast<int>(end) - 1);
        }
    }

  private:
    const Imath::Box2i& Window() const { return m_file.header().dataWindow(); }
    static uint32_t Extent(int first, int last) { return static_cast<uint32_t>(last - first + 1); }

    MemoryStream m_stream;
    Imf::InputFile m_file;
    Imf::FrameBuffer m_frame;
};

// Runs `decode(reader)` and converts the library's exceptions into Errors.
template <typename Decode>
auto WithReader(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits,
                const Decode& decode) {
    CheckExrHeader(bytes, name, limits);
    try {
        ExrReader reader(bytes, name);
        return decode(reader);
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw MakeError(ErrorKind::OutOfMemory, "{}: no memory for the picture", name);
    } catch (const std::exception& error) {
        Reject(name, std::string("EXR: ") + error.what());
    }
}

// Returns the first names, separated by spaces.
std::string ListOf(std::span<const std::string> names) {
    constexpr size_t kMostNames = 12;
    std::string list;
    for (size_t i = 0; i < std::min(names.size(), kMostNames); ++i) list += (i == 0 ? "" : " ") + names[i];
    return names.size() > kMostNames ? list + " ..." : list;
}

// Refuses a picture without colors by what it has instead: layers of them, or other channels.
[[noreturn]] void RejectWithoutColors(const Imf::ChannelList& channels, std::string_view name) {
    std::vector<std::string> layers, others;
    for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
        others.emplace_back(channel.name());
        if (!others.back().ends_with(".R")) continue;
        const std::string layer = others.back().substr(0, others.back().size() - 2);
        const auto has = [&](const char* suffix) { return channels.findChannel(layer + suffix) != nullptr; };
        if (has(".G") && has(".B")) layers.push_back(layer);
    }
    if (layers.empty()) Reject(name, "EXR: no R, G, B and no Y among its channels: " + ListOf(others));
    Reject(name,
           Text("EXR: R, G and B are in layers: {}; give one of them in a file of its own, as R, G and B",
                ListOf(layers)));
}

ExrAttributes ReadAttributes(const Imf::Header& header) {
    ExrAttributes attributes;
    for (auto it = header.begin(); it != header.end(); ++it) {
        if (IsFormatAttribute(it.name())) continue;
        const Imf::Attribute* attribute = &it.attribute();
        if (const auto* integer = dynamic_cast<const Imf::IntAttribute*>(attribute)) {
            attributes[it.name()] = int32_t{integer->value()};
        } else if (const auto* single = dynamic_cast<const Imf::FloatAttribute*>(attribute)) {
            attributes[it.name()] = single->value();
        } else if (const auto* wide = dynamic_cast<const Imf::DoubleAttribute*>(attribute)) {
            attributes[it.name()] = wide->value();
        } else if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(attribute)) {
            attributes[it.name()] = text->value();
        }
    }
    return attributes;
}

// Returns the matrix from RGB of these chromaticities to linear Rec. 709, for row vectors as OpenEXR has
// them. The white points are adapted by the Bradford transform (K. M. Lam, "Metamerism and Colour Constancy",
// 1985; the matrix is that of ICC.1), as OpenEXR does for ACES.
Imath::M33f ToRec709(const Imf::Chromaticities& from) {
    const auto linear = [](const Imath::M44f& m) {
        return Imath::M33f(m[0][0], m[0][1], m[0][2], m[1][0], m[1][1], m[1][2], m[2][0], m[2][1], m[2][2]);
    };
    const auto whiteXyz = [](const Imath::V2f& xy) {
        return Imath::V3f(xy.x / xy.y, 1.0f, (1.0f - xy.x - xy.y) / xy.y);
    };
    const Imf::Chromaticities rec709;
    const Imath::M33f toCones(0.8951f, -0.7502f, 0.0389f, 0.2664f, 1.7135f, -0.0685f, -0.1614f, 0.0367f,
                              1.0296f);
    const Imath::V3f cones = whiteXyz(from.white) * toCones, wanted = whiteXyz(rec709.white) * toCones;
    Imath::M33f scale;
    for (int i = 0; i < 3; ++i) scale[i][i] = wanted[i] / cones[i];
    return linear(Imf::RGBtoXYZ(from, 1.0f)) * toCones * scale * toCones.inverse() *
           linear(Imf::XYZtoRGB(rec709, 1.0f));
}

// Converts the colors to linear Rec. 709. It leaves every bit as it is if that is the file's color space,
// which it also is without the attribute.
void ConvertToRec709(ImageF& image, const Imf::Header& header, std::string_view name) {
    if (!Imf::hasChromaticities(header)) return;
    const Imf::Chromaticities& from = Imf::chromaticities(header);
    if (from == Imf::Chromaticities()) return;
    const Imath::M33f matrix = ToRec709(from);
    constexpr float kMaxElement = 1e4f;  // beyond it the chromaticities are degenerate
    for (int i = 0; i < 9; ++i)
        if (!(std::abs(matrix[i / 3][i % 3]) <= kMaxElement))
            Reject(name,
                   Text("EXR: chromaticities red {} {}, green {} {}, blue {} {}, white {} {} span no colors",
                        from.red.x, from.red.y, from.green.x, from.green.y, from.blue.x, from.blue.y,
                        from.white.x, from.white.y));
    for (size_t i = 0; i < image.rgba.size(); i += 4) {
        const Imath::V3f rgb = Imath::V3f(image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]) * matrix;
        for (size_t c = 0; c < 3; ++c) image.rgba[i + c] = rgb[static_cast<int>(c)];
    }
}

// Returns the picture in which `window` places `part`: black with alpha 0 where `part` has no pixels. Pixels
// of `part` outside the picture are dropped.
ImageF Placed(ImageF&& part, const ExrWindow& window, std::string_view name, const DecodeLimits& limits) {
    const int64_t width = window.pictureWidth, height = window.pictureHeight;
    if (window == ExrWindow{0, 0, part.width, part.height}) return std::move(part);
    CheckSize(name, static_cast<uint64_t>(width), static_cast<uint64_t>(height), limits);
    const int64_t left = std::max<int64_t>(window.x, 0), top = std::max<int64_t>(window.y, 0);
    const int64_t right = std::min(window.x + int64_t{part.width}, width);
    const int64_t bottom = std::min(window.y + int64_t{part.height}, height);
    if (left >= right || top >= bottom)
        Reject(name, Text("EXR: {} x {} pixels from {}, {} on are outside of its picture of {} x {}",
                          part.width, part.height, window.x, window.y, width, height));
    // The limit keeps a file of a few bytes from taking gigabytes of memory
    constexpr uint64_t kAlways = uint64_t{1} << 24, kPerPixel = 64;
    const uint64_t wanted = static_cast<uint64_t>(width * height);
    if (wanted > std::max(kAlways, kPerPixel * part.width * part.height))
        Reject(name, Text("EXR: {} x {} pixels are too few for a picture of {} x {}", part.width, part.height,
                          width, height));
    ImageF whole{window.pictureWidth, window.pictureHeight, std::vector<float>(4 * wanted)};
    for (int64_t y = top; y < bottom; ++y) {
        const auto from = part.rgba.begin() + 4 * ((y - window.y) * part.width + left - window.x);
        std::copy_n(from, 4 * (right - left), whole.rgba.begin() + 4 * (y * width + left));
    }
    return whole;
}

}  // namespace

ImageF DecodeExrColor(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits) {
    return WithReader(bytes, name, limits, [&](ExrReader& reader) {
        const Imf::Header& header = reader.Header();
        const Imf::ChannelList& channels = header.channels();
        const auto has = [&](const char* channel) { return channels.findChannel(channel) != nullptr; };
        const bool isRgb = has("R") && has("G") && has("B");
        if (!isRgb && has("Y") && (has("RY") || has("BY")))
            Reject(name, "EXR: luminance with chroma (Y, RY, BY) is not supported, only R, G, B or Y alone");
        const bool isGray = has("Y");
        if (!isRgb && !isGray) RejectWithoutColors(channels, name);
        const bool isEnvmap = Imf::hasEnvmap(header);
        if (isEnvmap && Imf::envmap(header) != Imf::ENVMAP_LATLONG)
            Reject(name,
                   Text("EXR: is {} by its envmap attribute; an environment is a latitude-longitude map",
                        Imf::envmap(header) == Imf::ENVMAP_CUBE ? "a cube map" : "of an unknown kind"));
        ImageF image{reader.Width(), reader.Height(), {}};
        image.rgba.reserve(4 * reader.PixelCount());
        float* rgba = image.rgba.data();
        if (isRgb) {
            reader.Add("R", Imf::FLOAT, rgba, 4);
            reader.Add("G", Imf::FLOAT, rgba + 1, 4);
            reader.Add("B", Imf::FLOAT, rgba + 2, 4);
        } else {
            reader.Add("Y", Imf::FLOAT, rgba, 4);
        }
        if (has("A")) reader.Add("A", Imf::FLOAT, rgba + 3, 4);
        reader.Read([&](size_t pixelCount) { image.rgba.resize(4 * pixelCount, 1.0f); });
        for (size_t i = 0; isGray && !isRgb && i < image.rgba.size(); i += 4) {
            image.rgba[i + 1] = image.rgba[i + 2] = image.rgba[i];
        }
        if (isRgb) ConvertToRec709(image, header, name);
        // ImfEnvmap.h says that the data window of a file with the attribute is the whole sphere
        return isEnvmap ? image : Placed(std::move(image), reader.WindowInPicture(), name, limits);
    });
}

ExrImage DecodeExr(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits) {
    if (SniffFormat(bytes) != FileFormat::Exr) Reject(name, "is not an OpenEXR file");
    return WithReader(bytes, name, limits, [&](ExrReader& reader) {
        ExrImage image{
            reader.Width(), reader.Height(), {}, ReadAttributes(reader.Header()), reader.WindowInPicture()};
        const Imf::ChannelList& channels = reader.Header().channels();
        for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
            ExrChannel& added = image.channels.emplace_back(ExrChannel{channel.name(), {}});
            const bool isUint = channel.channel().type == Imf::UINT;
            if (isUint) added.samples.emplace<std::vector<uint32_t>>();
            // The vector keeps its place when `added` moves.
            std::visit(
                [&](auto& samples) {
                    samples.reserve(reader.PixelCount());
                    reader.Add(added.name, isUint ? Imf::UINT : Imf::FLOAT, samples.data());
                },
                added.samples);
        }
        reader.Read([&](size_t pixelCount) {
            for (ExrChannel& channel : image.channels) {
                std::visit([&](auto& samples) { samples.resize(pixelCount); }, channel.samples);
            }
        });
        return image;
    });
}

ExrImage ReadExr(const std::filesystem::path& path, const DecodeLimits& limits) {
    return DecodeExr(ReadFile(path, uint64_t{1} << 34), Text("{}", path), limits);
}

namespace {

template <typename T>
const std::vector<T>* FindSamples(const ExrImage& image, std::string_view name) {
    for (const ExrChannel& channel : image.channels) {
        if (channel.name == name) return std::get_if<std::vector<T>>(&channel.samples);
    }
    return nullptr;
}

}  // namespace

const std::vector<float>* ExrImage::FloatChannel(std::string_view channelName) const {
    return FindSamples<float>(*this, channelName);
}

const std::vector<uint32_t>* ExrImage::UintChannel(std::string_view channelName) const {
    return FindSamples<uint32_t>(*this, channelName);
}

// --- The check of a header ---

namespace {

// Scan lines in a chunk (openexr.com, "OpenEXR File Layout"), by compression method: none, RLE, ZIPS, ZIP,
// PIZ, PXR24, B44, B44A, DWAA, DWAB.
constexpr std::array<uint32_t, 10> kLinesPerChunk = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
// The limit of samples of all channels together, padded to whole chunks or tiles: 4 GiB of float32.
constexpr uint64_t kMaxSampleCount = uint64_t{1} << 30;
constexpr uint64_t kMaxPaddedPixelCount = uint64_t{1} << 24;
constexpr int64_t kMaxCoordinate = int64_t{1} << 29;

// Gives the bytes of the types that OpenEXR reads by their own size, whatever size the file gives. With
// another size, the library would take other bytes for the next attribute than those that are checked here.
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
        Reject(m_name, Text("EXR: {}", Text(format, std::forward<Values>(values)...)));
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
    // Reads a string that ends with a zero.
    std::string ReadText(std::span<const std::byte>& bytes, const std::string& what) const {
        constexpr size_t kMaxLength = 255;  // with the long-names flag; without it, OpenEXR's limit is 31
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
        if (Imf::isMultiPart(version))
            Fail("multi-part files are not supported; its parts: {}; give one of them in a file of its own",
                 ListOf(ReadPartNames()));
        if (Imf::isNonImage(version)) Fail("deep pictures are not supported");
        m_isTiled = Imf::isTiled(version);
    }

    // Reads the headers of all parts. One that has no name is called by its number, from 0.
    std::vector<std::string> ReadPartNames() {
        std::vector<std::string> names;
        while (!m_rest.empty() && m_rest.front() != std::byte{0}) {
            names.push_back(std::to_string(names.size()));
            while (!m_rest.empty() && m_rest.front() != std::byte{0}) {
                const std::string attribute = ReadText(m_rest, "an attribute's name");
                ReadText(m_rest, "an attribute's type");
                const int32_t size = Int(Take(4, "an attribute"), 0);
                if (size < 0) Fail("attribute '{}' has negative size", attribute);
                const auto value = Take(static_cast<size_t>(size), "an attribute");
                if (attribute == "name")
                    names.back().assign(reinterpret_cast<const char*>(value.data()), value.size());
            }
            Take(1, "the header");
        }
        return names;
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
        if (type == "preview") {  // consists of width and height, then four bytes a pixel
            if (value.size() < 8) return false;
            const int64_t width = Int(value, 0), height = Int(value, 4), pixels = width * height;
            return width >= 0 && height >= 0 && pixels <= INT32_MAX &&
                   value.size() - 8 == 4 * static_cast<uint64_t>(pixels);
        }
        if (type == "stringvector") {  // consists of texts, each after its length
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
        constexpr size_t kEntryBytes = 16;  // type, linearity and padding, two samplings
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
        // All factors have 32 bits, so the products of two fit.
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

// --- Threads ---

namespace {

// The library has one pool of threads for the whole process.
struct Pool {
    std::mutex mutex;
    uint32_t users = 0;  // objects for which threads were started here
};
Pool& SharedPool() {
    static Pool pool;
    return pool;
}

}  // namespace

ExrThreads::ExrThreads(unsigned count) {
    constexpr unsigned kMax = 256;
    if (count == 0) count = std::thread::hardware_concurrency();
    if (count < 2) return;  // one thread is no gain
    Pool& pool = SharedPool();
    const std::lock_guard lock(pool.mutex);
    if (pool.users == 0) {
        if (Imf::globalThreadCount() > 0) return;  // the process has threads of its own
        Imf::setGlobalThreadCount(static_cast<int>(std::min(count, kMax)));
    }
    ++pool.users;
    m_isCounted = true;
}

ExrThreads::~ExrThreads() {
    if (!m_isCounted) return;
    Pool& pool = SharedPool();
    const std::lock_guard lock(pool.mutex);
    if (--pool.users == 0) Imf::setGlobalThreadCount(0);
}

}  // namespace raygraph::image
