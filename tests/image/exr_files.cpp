#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <cstring>

#include "tests/image/image_files.h"

namespace raygraph::test {
namespace {

class BytesStream final : public Imf::OStream {
  public:
    explicit BytesStream(Bytes& bytes) : OStream("memory"), m_bytes(bytes) {}
    void write(const char data[], int count) override {
        const auto size = static_cast<size_t>(count);
        if (m_bytes.size() < m_position + size) m_bytes.resize(m_position + size);
        std::memcpy(m_bytes.data() + m_position, data, size);
        m_position += size;
    }
    uint64_t tellp() override { return m_position; }
    void seekp(uint64_t position) override { m_position = position; }

  private:
    Bytes& m_bytes;
    uint64_t m_position = 0;
};

// Converts `values` to the type's representation.
std::vector<char> Convert(Imf::PixelType type, std::span<const float> values) {
    const auto pack = [&](auto convert) {
        using T = decltype(convert(0.0f));
        std::vector<char> out(values.size() * sizeof(T));
        for (size_t i = 0; i < values.size(); ++i) {
            const T value = convert(values[i]);
            std::memcpy(out.data() + i * sizeof(T), &value, sizeof(T));
        }
        return out;
    };
    if (type == Imf::HALF) return pack([](float value) { return half(value); });
    if (type == Imf::UINT) return pack([](float value) { return static_cast<uint32_t>(value); });
    return pack([](float value) { return value; });
}

}  // namespace

Bytes MakeExr(const ExrDesc& desc, std::span<const std::vector<float>> planes) {
    EXPECT_EQ(planes.size(), desc.channels.size());
    const auto width = static_cast<int>(desc.width), height = static_cast<int>(desc.height);
    const Imath::Box2i window({desc.minX, desc.minY}, {desc.minX + width - 1, desc.minY + height - 1});
    const Imath::Box2i ownSize({0, 0}, {width - 1, height - 1});
    Imf::Header header(ownSize, window);
    if (const auto& box = desc.picture)
        header.displayWindow() = Imath::Box2i({(*box)[0], (*box)[1]}, {(*box)[2], (*box)[3]});
    if (const auto& xy = desc.chromaticities)
        Imf::addChromaticities(
            header, {{(*xy)[0], (*xy)[1]}, {(*xy)[2], (*xy)[3]}, {(*xy)[4], (*xy)[5]}, {(*xy)[6], (*xy)[7]}});
    if (desc.envmap) Imf::addEnvmap(header, static_cast<Imf::Envmap>(*desc.envmap));
    header.compression() = desc.compression;
    Imf::FrameBuffer frame;
    std::vector<std::vector<char>> data;
    const size_t bytes = desc.type == Imf::HALF ? 2 : 4;
    for (size_t c = 0; c < planes.size(); ++c) {
        const int sampling = c + 1 == planes.size() ? desc.sampling : 1;
        header.channels().insert(desc.channels[c], Imf::Channel(desc.type, sampling, sampling));
        data.push_back(Convert(desc.type, planes[c]));
        const size_t rowTexels =
            (desc.width + static_cast<uint32_t>(sampling) - 1) / static_cast<uint32_t>(sampling);
        EXPECT_GE(data.back().size(), bytes * rowTexels);
        frame.insert(desc.channels[c], Imf::Slice::Make(desc.type, data.back().data(), window, bytes,
                                                        bytes * rowTexels, sampling, sampling));
    }
    Bytes out;
    BytesStream stream(out);
    if (desc.tileSize != 0) {
        header.setTileDescription(Imf::TileDescription(desc.tileSize, desc.tileSize, Imf::ONE_LEVEL));
        Imf::TiledOutputFile file(stream, header);
        file.setFrameBuffer(frame);
        file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    } else {
        Imf::OutputFile file(stream, header);
        file.setFrameBuffer(frame);
        file.writePixels(height);
    }
    return out;
}

Bytes MakeMultiPartExr() {
    std::vector<Imf::Header> headers(2, Imf::Header(4, 4));
    float values[16] = {};
    for (size_t i = 0; i < headers.size(); ++i) {
        headers[i].setName("part" + std::to_string(i));
        headers[i].setType(Imf::SCANLINEIMAGE);
        headers[i].channels().insert("Y", Imf::Channel(Imf::FLOAT));
    }
    Bytes out;
    BytesStream stream(out);
    {
        Imf::MultiPartOutputFile file(stream, headers.data(), 2);
        for (int i = 0; i < 2; ++i) {
            Imf::OutputPart part(file, i);
            Imf::FrameBuffer frame;
            frame.insert("Y", Imf::Slice::Make(Imf::FLOAT, values, headers[0].dataWindow(), 4, 16));
            part.setFrameBuffer(frame);
            part.writePixels(4);
        }
    }
    return out;
}

}  // namespace raygraph::test
