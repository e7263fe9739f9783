// PNG through libpng's row interface: its simplified one would apply gamma chunks, which glTF forbids.
#include <png.h>

#include <csetjmp>
#include <cstring>
#include <memory>
#include <new>

#include "base/files.h"
#include "base/text.h"
#include "renderer/image/decode.h"

namespace raygraph::image {
namespace {

// Owns libpng's state. Libpng reports failure by longjmp, so the functions that call it (ReadHeader,
// ReadRows) hold nothing with a destructor.
class PngReader {
  public:
    explicit PngReader(std::span<const std::byte> bytes) : m_rest(bytes) {
        m_png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, OnError, OnWarning);
        if (m_png != nullptr) m_info = png_create_info_struct(m_png);
        if (m_info != nullptr) png_set_read_fn(m_png, this, OnRead);
    }
    ~PngReader() { png_destroy_read_struct(&m_png, &m_info, nullptr); }
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;

    bool IsReady() const { return m_info != nullptr; }
    const char* Message() const { return m_message; }
    uint32_t Width() const { return png_get_image_width(m_png, m_info); }
    uint32_t Height() const { return png_get_image_height(m_png, m_info); }
    uint64_t FileRowBytes() const { return png_get_rowbytes(m_png, m_info); }

    // Reads everything before the pixels. Ancillary chunks but tRNS are skipped unparsed.
    bool ReadHeader() {
        if (setjmp(png_jmpbuf(m_png)) != 0) return false;
        png_set_keep_unknown_chunks(m_png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
        png_set_user_limits(m_png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // CheckSize() words it better
        png_read_info(m_png, m_info);
        return true;
    }

    // Decodes the pixels as 8-bit RGBA into `rows`. The file may be cut off after the last of them.
    bool ReadRows(png_bytepp rows) {
        if (setjmp(png_jmpbuf(m_png)) != 0) return m_isTruncated && HasAllRows();
        png_set_scale_16(m_png);
        png_set_expand(m_png);
        png_set_gray_to_rgb(m_png);
        png_set_add_alpha(m_png, 0xff, PNG_FILLER_AFTER);
        png_set_interlace_handling(m_png);
        png_read_update_info(m_png, m_info);
        if (FileRowBytes() != uint64_t{4} * Width()) png_error(m_png, "unexpected row size");
        png_read_image(m_png, rows);
        return true;
    }

    // Reads the rest of the file, which may be cut off. Returns false if something in it is broken.
    bool ReadEnd() {
        if (setjmp(png_jmpbuf(m_png)) != 0) return m_isTruncated;
        png_read_end(m_png, nullptr);
        return true;
    }
    // Returns whether the last read reached beyond the end of the file.
    bool IsTruncated() const { return m_isTruncated; }

  private:
    // An interlaced picture is read in seven passes over its rows.
    bool HasAllRows() const {
        return png_get_interlace_type(m_png, m_info) == PNG_INTERLACE_NONE
                   ? png_get_current_row_number(m_png) >= Height()
                   : png_get_current_pass_number(m_png) >= PNG_INTERLACE_ADAM7_PASSES;
    }
    static void OnError(png_structp png, png_const_charp message) {
        auto* reader = static_cast<PngReader*>(png_get_error_ptr(png));
        std::strncpy(reader->m_message, message, sizeof reader->m_message - 1);
        png_longjmp(png, 1);
    }
    static void OnWarning(png_structp, png_const_charp) {}
    static void OnRead(png_structp png, png_bytep out, size_t count) {
        auto* reader = static_cast<PngReader*>(png_get_io_ptr(png));
        reader->m_isTruncated = count > reader->m_rest.size();
        if (reader->m_isTruncated) png_error(png, "the file is truncated");
        std::memcpy(out, reader->m_rest.data(), count);
        reader->m_rest = reader->m_rest.subspan(count);
    }

    std::span<const std::byte> m_rest;
    png_structp m_png = nullptr;
    png_infop m_info = nullptr;
    char m_message[160] = "";
    bool m_isTruncated = false;
};

// Returns the texels without alpha, or nothing if some are not opaque.
std::vector<uint8_t> OpaqueTexels(const Image8& image) {
    std::vector<uint8_t> rgb;
    rgb.reserve(image.rgba.size() / 4 * 3);
    for (size_t i = 0; i < image.rgba.size(); i += 4) {
        if (image.rgba[i + 3] != 255) return {};
        rgb.insert(rgb.end(), {image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]});
    }
    return rgb;
}

}  // namespace

Image8 DecodePng(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits) {
    // Deflate stores at most 258 bytes in 2 bits.
    constexpr uint64_t kMaxDeflateRatio = 1032;
    PngReader reader(bytes);
    if (!reader.IsReady()) throw MakeError(ErrorKind::OutOfMemory, "{}: no memory for libpng", name);
    if (!reader.ReadHeader()) Reject(name, std::string("PNG: ") + reader.Message());
    const uint32_t width = reader.Width(), height = reader.Height();
    CheckSize(name, width, height, limits);
    if (reader.FileRowBytes() * height > bytes.size() * kMaxDeflateRatio) {
        Reject(name, Text("PNG: {} bytes cannot hold {} x {} pixels", bytes.size(), width, height));
    }
    try {
        Image8 image{width, height, std::vector<uint8_t>(size_t{4} * width * height)};
        std::vector<png_bytep> rows(height);
        for (size_t y = 0; y < height; ++y) rows[y] = image.rgba.data() + y * 4 * width;
        if (!reader.ReadRows(rows.data()) || (!reader.IsTruncated() && !reader.ReadEnd()))
            Reject(name, std::string("PNG: ") + reader.Message());
        if (reader.IsTruncated()) image.warnings.push_back(TruncationWarning(name));
        return image;
    } catch (const std::bad_alloc&) {
        RejectMemory(name, width, height);
    }
}

std::vector<std::byte> EncodePng(const Image8& image, std::string_view name) {
    CheckTexelCount(name, image.width, image.height, image.rgba.size());
    png_image png = {};
    png.version = PNG_IMAGE_VERSION;
    png.width = image.width;
    png.height = image.height;
    // PNGs are written with 8 bits, which means sRGB here: libpng says so in the file. They have no alpha
    // channel where alpha is 255 everywhere, because compressing it takes more than half of the time.
    const std::vector<uint8_t> opaque = OpaqueTexels(image);
    png.format = opaque.empty() ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    const std::vector<uint8_t>& texels = opaque.empty() ? image.rgba : opaque;
    // Libpng would not tell why a write has failed.
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::vector<std::byte> bytes(size);
    if (png_image_write_to_memory(&png, bytes.data(), &size, 0, texels.data(), 0, nullptr) == 0)
        throw MakeError(ErrorKind::OutOfMemory, "{}: PNG: {}", name, png.message);
    bytes.resize(size);
    return bytes;
}

void WritePng(const std::filesystem::path& path, const Image8& image) {
    CheckTexelCount(path, image.width, image.height, image.rgba.size());
    AtomicFile file(path);
    file.Write(EncodePng(image, path.string()));
    file.Commit();
}

}  // namespace raygraph::image
