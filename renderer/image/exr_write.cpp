#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>
#include <set>
#include <type_traits>

#include "base/files.h"
#include "base/text.h"
#include "renderer/image/exr.h"
#include "renderer/image/exr_read.h"

namespace raygraph::image {
namespace {

constexpr size_t kMaxNameLength = 255;
constexpr float kMaxHalf = 65504.0f;

// Sends OpenEXR's output into an AtomicFile. The library swallows errors of its last write, in a destructor;
// the AtomicFile remembers them for Commit().
class AtomicFileStream final : public Imf::OStream {
  public:
    AtomicFileStream(AtomicFile& file, const char* name) : OStream(name), m_file(file) {}
    void write(const char bytes[], int count) override {
        m_file.Write(std::as_bytes(std::span(bytes, static_cast<size_t>(count))));
    }
    uint64_t tellp() override { return m_file.Position(); }
    void seekp(uint64_t position) override { m_file.Seek(position); }

  private:
    AtomicFile& m_file;
};

class ExrWriter {
  public:
    ExrWriter(const std::filesystem::path& path, uint32_t width, uint32_t height, const ExrWindow& window)
        : m_path(path), m_width(width), m_height(height), m_header(CheckedHeader(window)) {
        m_header.compression() = Imf::ZIP_COMPRESSION;
        // The library's default level, 4, takes a quarter longer for renders, whose last bits are noise, to
        // save 2 % of their bytes
        m_header.zipCompressionLevel() = 1;
    }

    void Add(const ExrPlane& plane) {
        const std::string channel = Text("channel '{}'", plane.name);
        if (plane.name.empty() || plane.name.size() > kMaxNameLength ||
            plane.name.find('\0') != std::string::npos) {
            Fail(Text("{}: not a name", channel));
        }
        if (m_frame.findSlice(plane.name) != nullptr)
            Fail(Text("{}: there is one of this name already", channel));
        const uint64_t pixelCount = uint64_t{m_width} * m_height;
        std::visit(
            [&](const auto& samples) {
                const uint64_t needed = (pixelCount - 1) * plane.stride + 1;
                if (plane.stride == 0 || samples.size() < needed) {
                    Fail(Text("{}: {} numbers, {} needed", channel, samples.size(), needed));
                }
                constexpr bool kIsUint = std::is_same_v<decltype(samples.front()), const uint32_t&>;
                if constexpr (!kIsUint)
                    if (plane.isHalf) return AddHalf(plane.name, samples, plane.stride);
                if (plane.isHalf) Fail(Text("{}: whole numbers as half floats", channel));
                Insert(plane.name, kIsUint ? Imf::UINT : Imf::FLOAT, samples.data(), plane.stride, 4);
            },
            plane.samples);
    }

    void Add(const std::string& name, const ExrAttribute& attribute) {
        if (name.empty() || name.size() > kMaxNameLength || name.find('\0') != std::string::npos ||
            IsFormatAttribute(name)) {
            Fail(Text("attribute '{}': the name is the format's own or none", name));
        }
        std::visit(
            [&](const auto& value) {
                using T = std::decay_t<decltype(value)>;
                m_header.insert(name, Imf::TypedAttribute<T>(value));
            },
            attribute);
    }

    // Returns the number of samples beyond the range of a half float.
    uint64_t ClampedCount() const { return m_clampedCount; }

    void Write() {
        if (m_header.channels().begin() == m_header.channels().end()) Fail("there are no channels");
        AtomicFile file(m_path);
        {
            AtomicFileStream stream(file, m_path.c_str());
            Imf::OutputFile output(stream, m_header);
            output.setFrameBuffer(m_frame);
            output.writePixels(static_cast<int>(m_height));
        }
        file.Commit();
    }

  private:
    void Insert(const std::string& name, Imf::PixelType type, const void* samples, size_t stride,
                size_t bytes) {
        m_header.channels().insert(name, Imf::Channel(type));
        const size_t step = stride * bytes;
        m_frame.insert(name, Imf::Slice::Make(type, samples, m_header.dataWindow(), step, step * m_width));
    }
    void AddHalf(const std::string& name, std::span<const float> samples, size_t stride) {
        std::vector<half>& halves = m_halves.emplace_back(size_t{m_width} * m_height);
        for (size_t i = 0; i < halves.size(); ++i) {
            const float value = samples[i * stride];
            if (std::abs(value) > kMaxHalf) ++m_clampedCount;
            halves[i] = half(std::isnan(value) ? value : std::clamp(value, -kMaxHalf, kMaxHalf));
        }
        Insert(name, Imf::HALF, halves.data(), 1, sizeof(half));
    }
    [[noreturn]] void Fail(const std::string& what) const {
        throw MakeError(ErrorKind::Usage, "{}: {}", m_path, what);
    }
    Imf::Header CheckedHeader(const ExrWindow& window) const {
        constexpr int64_t kMaxSide = 1 << 29;
        const int64_t width = m_width, height = m_height;
        if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide)
            Fail(Text("cannot write {} x {} pixels", m_width, m_height));
        // The sides of both windows are checked, so that the positions of the last pixels can be represented.
        const int64_t pictureWidth = window.pictureWidth > 0 ? window.pictureWidth : width;
        const int64_t pictureHeight = window.pictureHeight > 0 ? window.pictureHeight : height;
        if (std::max(pictureWidth, pictureHeight) > kMaxSide ||
            std::max(std::abs(int64_t{window.x}), std::abs(int64_t{window.y})) > kMaxSide / 2)
            Fail(Text("cannot write pixels from {}, {} on, of a picture of {} x {}", window.x, window.y,
                      pictureWidth, pictureHeight));
        const Imath::V2i last(static_cast<int>(window.x + width - 1),
                              static_cast<int>(window.y + height - 1));
        return Imf::Header(
            Imath::Box2i({0, 0}, {static_cast<int>(pictureWidth - 1), static_cast<int>(pictureHeight - 1)}),
            Imath::Box2i({window.x, window.y}, last));
    }

    const std::filesystem::path& m_path;
    uint32_t m_width, m_height;
    Imf::Header m_header;
    Imf::FrameBuffer m_frame;
    std::vector<std::vector<half>> m_halves;  // of the planes that are stored as half
    uint64_t m_clampedCount = 0;
};

}  // namespace

uint64_t WriteExr(const std::filesystem::path& path, uint32_t width, uint32_t height,
                  std::span<const ExrPlane> planes, const ExrAttributes& attributes,
                  const ExrWindow& window) {
    try {
        ExrWriter writer(path, width, height, window);
        for (const ExrPlane& plane : planes) writer.Add(plane);
        for (const auto& [name, attribute] : attributes) writer.Add(name, attribute);
        writer.Write();
        return writer.ClampedCount();
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw MakeError(ErrorKind::OutOfMemory, "{}: no memory to compress the picture", path);
    } catch (const std::exception& error) {
        throw MakeError(ErrorKind::Io, "{}: cannot write: {}", path, error.what());
    }
}

void WriteExr(const std::filesystem::path& path, const ExrImage& image) {
    std::vector<ExrPlane> planes;
    for (const ExrChannel& channel : image.channels) {
        ExrPlane plane{channel.name, {}};
        std::visit([&](const auto& samples) { plane.samples = std::span(samples); }, channel.samples);
        planes.push_back(std::move(plane));
    }
    WriteExr(path, image.width, image.height, planes, image.attributes, image.window);
}

}  // namespace raygraph::image
