#include <csetjmp>
#include <cstdio>
#include <new>

// jpeglib.h needs stdio first.
#include <jpeglib.h>

#include <jerror.h>

#include "base/error.h"
#include "renderer/image/decode.h"

namespace raygraph::image {
namespace {

// Multiplies colors by black; Adobe writes CMYK inverted.
void CmykToRgba(uint8_t* texels, uint32_t width, bool isInverted) {
    for (uint32_t x = 0; x < width; ++x, texels += 4) {
        for (int c = 0; c < 4; ++c) {
            if (!isInverted) texels[c] = static_cast<uint8_t>(255 - texels[c]);
        }
        const int light = texels[3];
        for (int c = 0; c < 3; ++c) texels[c] = static_cast<uint8_t>((texels[c] * light + 127) / 255);
        texels[3] = 255;
    }
}

// Owns libjpeg's state. Libjpeg reports failure by longjmp out of OnError, so the functions that call it
// (ReadHeader, ReadRow, ...) hold nothing with a destructor.
class JpegReader {
  public:
    JpegReader() {
        m_jpeg.err = jpeg_std_error(&m_errors.base);
        m_errors.base.error_exit = OnError;
        m_errors.base.emit_message = OnMessage;
        m_progress.progress_monitor = OnProgress;
    }
    ~JpegReader() { jpeg_destroy_decompress(&m_jpeg); }
    JpegReader(const JpegReader&) = delete;
    JpegReader& operator=(const JpegReader&) = delete;

    const char* Message() const { return m_errors.message; }
    uint32_t Width() const { return m_jpeg.image_width; }
    uint32_t Height() const { return m_jpeg.image_height; }

    bool ReadHeader(std::span<const std::byte> bytes) {
        if (setjmp(m_errors.jump) != 0) return false;
        jpeg_create_decompress(&m_jpeg);
        m_jpeg.progress = &m_progress;
        jpeg_mem_src(&m_jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
        jpeg_read_header(&m_jpeg, TRUE);
        return true;
    }
    bool Start() {
        if (setjmp(m_errors.jump) != 0) return false;
        m_jpeg.out_color_space = IsCmyk() ? JCS_CMYK : JCS_EXT_RGBA;
        jpeg_start_decompress(&m_jpeg);
        return true;
    }
    // Reads one row of RGBA.
    bool ReadRow(uint8_t* row) {
        if (setjmp(m_errors.jump) != 0) return false;
        jpeg_read_scanlines(&m_jpeg, &row, 1);
        if (IsCmyk()) CmykToRgba(row, Width(), m_jpeg.saw_Adobe_marker != FALSE);
        return true;
    }
    // Reads the rest of the file, after the last row.
    bool Finish() {
        if (setjmp(m_errors.jump) != 0) return false;
        const bool isWhole = HasAllScans();
        jpeg_finish_decompress(&m_jpeg);
        if (m_errors.isTruncated && !isWhole) ERREXIT(&m_jpeg, JERR_INPUT_EOF);
        return true;
    }
    // Is valid after Finish: returns whether the file lacks its end marker although it has the whole picture.
    bool IsTruncated() const { return m_errors.isTruncated; }

  private:
    struct Errors {
        jpeg_error_mgr base;  // comes first: libjpeg's pointer to it is a pointer to this
        std::jmp_buf jump;
        char message[JMSG_LENGTH_MAX];
        bool isTruncated;
    };
    // A progressive file of very many scans takes minutes to decode; cameras and encoders make about ten.
    static constexpr int kMaxScanCount = 100;

    bool IsCmyk() const { return m_jpeg.jpeg_color_space == JCS_CMYK || m_jpeg.jpeg_color_space == JCS_YCCK; }
    [[noreturn]] static void Jump(j_common_ptr jpeg) {
        std::longjmp(reinterpret_cast<Errors*>(jpeg->err)->jump, 1);
    }
    [[noreturn]] static void OnError(j_common_ptr jpeg) {
        jpeg->err->format_message(jpeg, reinterpret_cast<Errors*>(jpeg->err)->message);
        Jump(jpeg);
    }
    // Returns whether every component has been in a scan, and every coefficient in one that makes it exact.
    // Data that a sequential file lacks within a scan is an error of OnMessage. Arithmetic coding omits zeros
    // at the end of a scan, so that missing ones cannot be told apart: it never has all scans.
    bool HasAllScans() const {
        if (m_jpeg.arith_code != FALSE) return false;
        for (int c = 0; c < m_jpeg.num_components; ++c) {
            if (m_jpeg.comp_info[c].quant_table == nullptr) return false;
            for (int k = 0; m_jpeg.coef_bits != nullptr && k < DCTSIZE2; ++k)
                if (m_jpeg.coef_bits[c][k] != 0) return false;
        }
        return true;
    }

    // Libjpeg invents pixels where data is missing, which is refused here. Its other warnings leave the
    // picture complete, as does a missing end after all scans, for which libjpeg inserts an end marker.
    static void OnMessage(j_common_ptr jpeg, int level) {
        if (level >= 0) return;
        switch (jpeg->err->msg_code) {
            case JWRN_JPEG_EOF:
                reinterpret_cast<Errors*>(jpeg->err)->isTruncated = true;
                break;
            case JWRN_HIT_MARKER:
            case JWRN_HUFF_BAD_CODE:
            case JWRN_ARITH_BAD_CODE:
                OnError(jpeg);
            default:
                break;
        }
    }
    static void OnProgress(j_common_ptr jpeg) {
        if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number <= kMaxScanCount) return;
        Errors* errors = reinterpret_cast<Errors*>(jpeg->err);
        std::snprintf(errors->message, sizeof errors->message, "more than %d scans", kMaxScanCount);
        Jump(jpeg);
    }

    jpeg_decompress_struct m_jpeg = {};
    jpeg_progress_mgr m_progress = {};
    Errors m_errors = {};
};

}  // namespace

Image8 DecodeJpeg(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits) {
    JpegReader reader;
    const auto check = [&](bool isDone) {
        if (!isDone) Reject(name, std::string("JPEG: ") + reader.Message());
    };
    check(reader.ReadHeader(bytes));
    const uint32_t width = reader.Width(), height = reader.Height();
    CheckSize(name, width, height, limits);
    check(reader.Start());
    try {
        Image8 image{width, height, {}};
        // Memory is touched row by row, so a header that promises more than the file holds costs nothing.
        const size_t rowBytes = size_t{4} * width;
        image.rgba.reserve(rowBytes * height);
        for (size_t y = 0; y < height; ++y) {
            image.rgba.resize(rowBytes * (y + 1));
            check(reader.ReadRow(image.rgba.data() + rowBytes * y));
        }
        check(reader.Finish());
        if (reader.IsTruncated()) image.warnings.push_back(TruncationWarning(name));
        return image;
    } catch (const std::bad_alloc&) {
        RejectMemory(name, width, height);
    }
}

}  // namespace raygraph::image
