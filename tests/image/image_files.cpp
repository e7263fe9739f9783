#include "tests/image/image_files.h"

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
#include <cstring>

#include <gtest/gtest.h>
#include <png.h>
#include <webp/encode.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

// jpeglib.h needs stdio first.
#include <jpeglib.h>

#include "base/error.h"
#include "tests/support/error_of.h"

namespace raygraph::test {

Bytes ToBytes(std::string_view text) {
    const auto bytes = std::as_bytes(std::span(text));
    return Bytes(bytes.begin(), bytes.end());
}

image::Image8 Pattern(uint32_t width, uint32_t height) {
    image::Image8 image{width, height, {}};
    for (uint32_t y = 0; y < height; ++y) {
        for (uint32_t x = 0; x < width; ++x) {
            const uint32_t i = y * width + x;
            image.rgba.push_back(static_cast<uint8_t>(i * 37 + 5));
            image.rgba.push_back(static_cast<uint8_t>(i * 91 + y));
            image.rgba.push_back(static_cast<uint8_t>(i * 53 ^ (x << 3)));
            image.rgba.push_back(static_cast<uint8_t>(1 + i % 255));
        }
    }
    return image;
}

Bytes MakePng(const PngDesc& desc, std::span<const uint8_t> rows) {
    Bytes out;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    const auto append = [](png_structp writer, png_bytep data, size_t count) {
        const auto bytes = std::as_bytes(std::span(data, count));
        auto* target = static_cast<Bytes*>(png_get_io_ptr(writer));
        target->insert(target->end(), bytes.begin(), bytes.end());
    };
    png_set_write_fn(png, &out, append, [](png_structp) {});
    png_set_IHDR(png, info, desc.width, desc.height, desc.bitDepth, desc.colorType,
                 desc.isInterlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    std::vector<png_color> palette;
    for (size_t i = 0; i + 2 < desc.palette.size(); i += 3) {
        palette.push_back({desc.palette[i], desc.palette[i + 1], desc.palette[i + 2]});
    }
    if (!palette.empty()) png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
    if (!desc.transparency.empty()) {
        png_set_tRNS(png, info, desc.transparency.data(), static_cast<int>(desc.transparency.size()),
                     nullptr);
    }
    if (!desc.transparentColor.empty()) {
        png_color_16 color = {};
        color.gray = color.red = desc.transparentColor.front();
        if (desc.transparentColor.size() == 3) {
            color.green = desc.transparentColor[1];
            color.blue = desc.transparentColor[2];
        }
        png_set_tRNS(png, info, nullptr, 0, &color);
    }
    if (desc.gamma) png_set_gAMA(png, info, *desc.gamma);
    png_write_info(png, info);
    const size_t rowBytes = png_get_rowbytes(png, info);
    EXPECT_EQ(rows.size(), rowBytes * desc.height);
    std::vector<uint8_t> copy(rows.begin(), rows.end());
    std::vector<png_bytep> pointers;
    for (size_t y = 0; y < desc.height; ++y) pointers.push_back(copy.data() + y * rowBytes);
    png_write_image(png, pointers.data());
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return out;
}

Bytes MakeJpeg(JpegKind kind, uint32_t width, uint32_t height, std::span<const uint8_t> texels) {
    const bool isCmyk = kind == JpegKind::PlainCmyk || kind == JpegKind::AdobeCmyk;
    jpeg_compress_struct jpeg = {};
    jpeg_error_mgr errors = {};
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    unsigned char* buffer = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&jpeg, &buffer, &size);
    jpeg.image_width = width;
    jpeg.image_height = height;
    jpeg.input_components = isCmyk ? 4 : kind == JpegKind::Gray ? 1 : 3;
    jpeg.in_color_space = isCmyk ? JCS_CMYK : kind == JpegKind::Gray ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    for (int c = 0; c < jpeg.num_components; ++c) {
        jpeg.comp_info[c].h_samp_factor = jpeg.comp_info[c].v_samp_factor = 1;
    }
    if (kind == JpegKind::ProgressiveRgb) jpeg_simple_progression(&jpeg);
    constexpr jpeg_scan_info kScans[] = {{1, {0}, 0, 63, 0, 0}, {1, {1}, 0, 63, 0, 0}, {1, {2}, 0, 63, 0, 0}};
    if (kind == JpegKind::RgbInThreeScans) {
        jpeg.scan_info = kScans;
        jpeg.num_scans = 3;
    }
    if (kind == JpegKind::RestartedRgb) jpeg.restart_interval = 1;
    if (kind == JpegKind::ArithmeticRgb) jpeg.arith_code = TRUE;
    if (kind == JpegKind::PlainCmyk) jpeg.write_Adobe_marker = FALSE;
    jpeg_start_compress(&jpeg, TRUE);
    const size_t rowBytes = size_t{width} * static_cast<size_t>(jpeg.input_components);
    EXPECT_EQ(texels.size(), rowBytes * height);
    for (size_t y = 0; y < height; ++y) {
        std::vector<uint8_t> row(texels.begin() + static_cast<ptrdiff_t>(y * rowBytes),
                                 texels.begin() + static_cast<ptrdiff_t>((y + 1) * rowBytes));
        JSAMPROW pointer = row.data();
        jpeg_write_scanlines(&jpeg, &pointer, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    const auto bytes = std::as_bytes(std::span(buffer, size));
    Bytes out(bytes.begin(), bytes.end());
    std::free(buffer);
    return out;
}

namespace {

Bytes TakeWebp(uint8_t* data, size_t size) {
    EXPECT_GT(size, 0u);
    const auto bytes = std::as_bytes(std::span(data, size));
    Bytes out(bytes.begin(), bytes.end());
    WebPFree(data);
    return out;
}

}  // namespace

Bytes MakeLosslessWebp(const image::Image8& image) {
    uint8_t* data = nullptr;
    const auto width = static_cast<int>(image.width), height = static_cast<int>(image.height);
    const size_t size = WebPEncodeLosslessRGBA(image.rgba.data(), width, height, 4 * width, &data);
    return TakeWebp(data, size);
}

Bytes MakeLossyWebp(const image::Image8& image, float quality) {
    uint8_t* data = nullptr;
    const auto width = static_cast<int>(image.width), height = static_cast<int>(image.height);
    const size_t size = WebPEncodeRGBA(image.rgba.data(), width, height, 4 * width, quality, &data);
    return TakeWebp(data, size);
}

Bytes MakeHdr(uint32_t width, uint32_t height, std::span<const uint8_t> body, std::string_view headerLines) {
    Bytes out = ToBytes("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n" + std::string(headerLines) + "\n-Y " +
                        std::to_string(height) + " +X " + std::to_string(width) + "\n");
    const auto bytes = std::as_bytes(body);
    out.insert(out.end(), bytes.begin(), bytes.end());
    return out;
}

size_t Find(const Bytes& bytes, std::string_view text) {
    const Bytes wanted = ToBytes(text);
    const auto found = std::search(bytes.begin(), bytes.end(), wanted.begin(), wanted.end());
    EXPECT_NE(found, bytes.end()) << text;
    return static_cast<size_t>(found - bytes.begin());
}

std::string Refusal(std::string_view name, const std::function<void()>& decode) {
    const std::string message = testing::ErrorTextOf(decode, ErrorKind::BadInput);
    EXPECT_TRUE(message.starts_with(std::string(name) + ": ")) << message;
    return message;
}

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
