#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

// jpeglib.h needs stdio first.
#include <jpeglib.h>

#include "base/error.h"
#include "base/files.h"
#include "renderer/image/decode.h"
#include "renderer/image/image.h"

namespace raygraph::image {
namespace {

constexpr int kQuality = 92;

// Owns libjpeg's state, which reports failure by longjmp out of OnError: Encode holds nothing with a
// destructor.
class JpegWriter {
  public:
    JpegWriter() {
        m_jpeg.err = jpeg_std_error(&m_errors.base);
        m_errors.base.error_exit = OnError;
    }
    ~JpegWriter() {
        jpeg_destroy_compress(&m_jpeg);
        std::free(m_bytes);
    }
    JpegWriter(const JpegWriter&) = delete;
    JpegWriter& operator=(const JpegWriter&) = delete;

    const char* Message() const { return m_errors.message; }
    std::span<const std::byte> Bytes() const { return std::as_bytes(std::span(m_bytes, m_size)); }

    bool Encode(const Image8& image) {
        if (setjmp(m_errors.jump) != 0) return false;
        jpeg_create_compress(&m_jpeg);
        jpeg_mem_dest(&m_jpeg, &m_bytes, &m_size);
        m_jpeg.image_width = image.width;
        m_jpeg.image_height = image.height;
        m_jpeg.input_components = 4;
        m_jpeg.in_color_space = JCS_EXT_RGBX;
        jpeg_set_defaults(&m_jpeg);
        jpeg_set_quality(&m_jpeg, kQuality, TRUE);
        m_jpeg.comp_info[0].h_samp_factor = m_jpeg.comp_info[0].v_samp_factor = 1;  // as the color's
        jpeg_start_compress(&m_jpeg, TRUE);
        while (m_jpeg.next_scanline < m_jpeg.image_height) {
            const uint8_t* texels = image.rgba.data() + size_t{4} * m_jpeg.next_scanline * image.width;
            JSAMPROW row = const_cast<JSAMPROW>(texels);  // NOLINT: libjpeg reads it alone
            jpeg_write_scanlines(&m_jpeg, &row, 1);
        }
        jpeg_finish_compress(&m_jpeg);
        return true;
    }

  private:
    struct Errors {
        jpeg_error_mgr base;  // comes first: libjpeg's pointer to it is a pointer to this
        std::jmp_buf jump;
        char message[JMSG_LENGTH_MAX];
    };
    [[noreturn]] static void OnError(j_common_ptr jpeg) {
        Errors* errors = reinterpret_cast<Errors*>(jpeg->err);
        jpeg->err->format_message(jpeg, errors->message);
        std::longjmp(errors->jump, 1);
    }

    jpeg_compress_struct m_jpeg = {};
    Errors m_errors = {};
    unsigned char* m_bytes = nullptr;
    unsigned long m_size = 0;  // NOLINT: libjpeg's type
};

}  // namespace

void WriteJpeg(const std::filesystem::path& path, const Image8& image) {
    CheckTexelCount(path, image.width, image.height, image.rgba.size());
    AtomicFile file(path);
    JpegWriter writer;
    if (!writer.Encode(image))
        throw MakeError(ErrorKind::OutOfMemory, "{}: JPEG: {}", path, writer.Message());
    file.Write(writer.Bytes());
    file.Commit();
}

}  // namespace raygraph::image
