// Tests malformed files: wrong sizes, wrong lengths, broken contents.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <zstd.h>

#include <ctime>
#include <map>
#include <random>

#include "base/error.h"
#include "renderer/image/exr.h"
#include "tests/image/image_files.h"
#include "tests/image/texture_files.h"
#include "tests/image/uastc_writer.h"

namespace raygraph::test::hostile_test {
namespace {

using image::DecodeLimits;

struct Sample {
    std::string name;
    Bytes bytes;
};

// Makes blocks that cycle through all modes.
std::vector<uint8_t> RandomUastc(size_t blockCount) {
    std::mt19937 random(1);
    std::vector<uint8_t> bytes;
    for (size_t i = 0; i < blockCount; ++i)
        for (const std::byte byte : Pack(RandomUastcBlock(i % 19, random)))
            bytes.push_back(std::to_integer<uint8_t>(byte));
    return bytes;
}

Bytes Zstandard(const image::Image8& image) {
    std::vector<uint8_t> packed(ZSTD_compressBound(image.rgba.size()));
    packed.resize(ZSTD_compress(packed.data(), packed.size(), image.rgba.data(), image.rgba.size(), 3));
    return MakeKtx2({.vkFormat = kVkRgba8,
                     .width = image.width,
                     .height = image.height,
                     .supercompression = 2,
                     .inflatedBytes = image.rgba.size()},
                    packed);
}

// Makes a small valid file of every kind that is read.
std::vector<Sample> Samples() {
    const image::Image8 pattern = Pattern(12, 9);
    std::vector<uint8_t> rgb;
    for (size_t i = 0; i < pattern.rgba.size(); ++i) {
        if (i % 4 != 3) rgb.push_back(pattern.rgba[i]);
    }
    std::vector<std::vector<float>> planes(3);
    for (size_t i = 0; i < 12 * 9; ++i) {
        for (auto& plane : planes) plane.push_back(static_cast<float>(i * 31 % 17));
    }
    const std::vector<uint8_t> flat(pattern.rgba);
    std::vector<uint8_t> newRle;
    for (int y = 0; y < 9; ++y) {
        newRle.insert(newRle.end(), {2, 2, 0, 12});
        for (int c = 0; c < 4; ++c) newRle.insert(newRle.end(), {128 + 8, 100, 4, 1, 2, 3, 4});
    }
    std::vector<Sample> samples = {
        {"rgba.png", MakePng({.width = 12, .height = 9}, pattern.rgba)},
        {"interlaced.png", MakePng({.width = 12, .height = 9, .isInterlaced = true}, pattern.rgba)},
        {"palette.png",
         MakePng({.width = 2, .colorType = 3, .palette = {1, 2, 3, 4, 5, 6}, .transparency = {9}},
                 std::vector<uint8_t>{0, 1})},
        {"baseline.jpg", MakeJpeg(JpegKind::Rgb, 12, 9, rgb)},
        {"progressive.jpg", MakeJpeg(JpegKind::ProgressiveRgb, 12, 9, rgb)},
        {"scans.jpg", MakeJpeg(JpegKind::RgbInThreeScans, 12, 9, rgb)},
        {"restarted.jpg", MakeJpeg(JpegKind::RestartedRgb, 12, 9, rgb)},
        {"arithmetic.jpg", MakeJpeg(JpegKind::ArithmeticRgb, 12, 9, rgb)},
        {"cmyk.jpg", MakeJpeg(JpegKind::AdobeCmyk, 12, 9, pattern.rgba)},
        {"lossless.webp", MakeLosslessWebp(pattern)},
        {"lossy.webp", MakeLossyWebp(pattern, 80.0f)},
        {"plain.dds", MakeDds({.width = 12, .height = 9}, pattern.rgba)},
        {"gray.dds",
         MakeDds({.width = 12, .height = 9, .bitCount = 8, .masks = {0xFF}, .formatFlags = 0x20000},
                 std::span(pattern.rgba).first(12 * 9))},
        {"bc1.dds", MakeDds({.width = 12, .height = 9, .fourCc = "DXT1"}, std::span(pattern.rgba).first(72))},
        {"bc7.dds",
         MakeDds({.width = 12, .height = 9, .dxgiFormat = kDxgiBc7}, std::span(pattern.rgba).first(144))},
        {"plain.ktx2", MakeKtx2({.vkFormat = kVkRgba8, .width = 12, .height = 9}, pattern.rgba)},
        {"bc7.ktx2",
         MakeKtx2({.vkFormat = kVkBc7, .width = 12, .height = 9}, std::span(pattern.rgba).first(144))},
        {"zstd.ktx2", Zstandard(pattern)},
        {"uastc.ktx2",
         MakeKtx2({.width = 12, .height = 9, .model = kUastc, .channels = {3}}, RandomUastc(9))},
        {"etc1s.ktx2", MakeBasisLz(RandomBasisPicture(12, 9, false, 1))},
        {"etc1s_alpha.ktx2", MakeBasisLz(RandomBasisPicture(12, 9, true, 2))},
        {"flat.hdr", MakeHdr(12, 9, flat)},
        {"rle.hdr", MakeHdr(12, 9, newRle)},
    };
    for (int method = 0; method < Imf::NUM_COMPRESSION_METHODS; ++method) {
        const ExrDesc desc{.width = 12,
                           .height = 9,
                           .type = Imf::HALF,
                           .compression = static_cast<Imf::Compression>(method)};
        samples.push_back({"lines" + std::to_string(method) + ".exr", MakeExr(desc, planes)});
    }
    samples.push_back({"tiles.exr", MakeExr({.width = 12, .height = 9, .tileSize = 8}, planes)});
    return samples;
}

// Decodes the file with its reader, an EXR with both.
void Decode(const Bytes& bytes, const std::string& name, const DecodeLimits& limits) {
    if (name.ends_with(".exr")) image::DecodeExr(bytes, name, limits);
    if (name.ends_with(".exr") || name.ends_with(".hdr")) {
        image::DecodeEnvironment(bytes, name, limits);
    } else {
        image::DecodeImage8(bytes, name, limits);
    }
}

constexpr DecodeLimits kSmall{.maxWidth = 64, .maxHeight = 64, .maxPixels = 4096};

// Returns whether `prefix` of a PNG or a JPEG is read; if so, it must have the texels of the whole file, and
// a warning.
bool IsWhole(const Bytes& prefix, const Sample& sample) {
    if (!sample.name.ends_with(".png") && !sample.name.ends_with(".jpg")) return false;
    image::Image8 image;
    try {
        image = image::DecodeImage8(prefix, sample.name, kSmall);
    } catch (const Error&) {
        return false;
    }
    EXPECT_EQ(image.rgba, image::DecodeImage8(sample.bytes, sample.name, kSmall).rgba);
    EXPECT_EQ(image.warnings,
              std::vector<std::string>{sample.name + ": the file is cut off behind its last pixel"});
    return true;
}

// The decoders invent no texel of a truncated file, wherever it ends.
TEST(Hostile, EveryTruncationIsRefusedUnlessAllTexelsAreThere) {
    std::map<std::string, size_t> cutOff;
    for (const Sample& sample : Samples()) {
        Decode(sample.bytes, sample.name, kSmall);
        for (size_t length = 0; length < sample.bytes.size(); ++length) {
            const Bytes prefix(sample.bytes.begin(), sample.bytes.begin() + static_cast<ptrdiff_t>(length));
            SCOPED_TRACE(sample.name + ", " + std::to_string(length) + " of " +
                         std::to_string(sample.bytes.size()));
            if (IsWhole(prefix, sample)) {
                ++cutOff[sample.name];
                continue;
            }
            Refusal(sample.name, [&] { Decode(prefix, sample.name, kSmall); });
            if (::testing::Test::HasFailure()) return;
        }
    }
    // A JPEG may lack at least the two bytes of its end marker, a PNG the twelve of its end chunk
    // and the four of the checksum before it.
    for (const char* jpeg : {"baseline.jpg", "progressive.jpg", "scans.jpg", "restarted.jpg", "cmyk.jpg"})
        EXPECT_GE(cutOff[jpeg], 2u) << jpeg;
    for (const char* png : {"rgba.png", "interlaced.png", "palette.png"}) EXPECT_GE(cutOff[png], 16u) << png;
}

// A changed file is read or refused, with the same kind of error as any other; under the sanitizers this also
// shows that nothing out of bounds is touched.
TEST(Hostile, ChangedBytesNeverDoMoreThanAnError) {
    std::mt19937 random(1);
    for (const Sample& sample : Samples()) {
        size_t refusedCount = 0;
        for (int round = 0; round < 500; ++round) {
            Bytes bytes = sample.bytes;
            const uint32_t changeCount = 1 + random() % 4;
            for (uint32_t i = 0; i < changeCount; ++i) {
                const size_t at = random() % bytes.size();
                const uint32_t kind = random() % 4;
                bytes[at] = kind == 0   ? std::byte{0xff}
                            : kind == 1 ? std::byte{0}
                            : kind == 2 ? bytes[at] ^ static_cast<std::byte>(1u << random() % 8)
                                        : static_cast<std::byte>(random());
            }
            try {
                Decode(bytes, sample.name, kSmall);
            } catch (const Error& error) {
                ++refusedCount;
                ASSERT_EQ(error.Kind(), ErrorKind::BadInput) << error.what();
                ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
            }
        }
        EXPECT_GT(refusedCount, 20u) << sample.name;
    }
}

uint32_t Crc(std::span<const std::byte> bytes) {
    uint32_t crc = ~0u;
    for (const std::byte byte : bytes) {
        crc ^= std::to_integer<uint32_t>(byte);
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

void PutBig(Bytes& bytes, size_t at, uint32_t value, size_t count = 4) {
    for (size_t i = 0; i < count; ++i) bytes[at + i] = static_cast<std::byte>(value >> (8 * (count - 1 - i)));
}

void PutLittle(Bytes& bytes, size_t at, uint32_t value) {
    for (size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::byte>(value >> (8 * i));
}

// Makes a valid small file that claims another size.
Bytes PngClaiming(uint32_t width, uint32_t height) {
    Bytes bytes = MakePng({.width = 12, .height = 9}, Pattern(12, 9).rgba);
    PutBig(bytes, 16, width);
    PutBig(bytes, 20, height);
    PutBig(bytes, 29, Crc(std::span(bytes).subspan(12, 17)));
    return bytes;
}

Bytes JpegClaiming(uint32_t width, uint32_t height) {
    Bytes bytes = MakeJpeg(JpegKind::ProgressiveRgb, 12, 9, std::vector<uint8_t>(12 * 9 * 3));
    const size_t frame = Find(bytes, "\xff\xc2");
    PutBig(bytes, frame + 5, height, 2);
    PutBig(bytes, frame + 7, width, 2);
    return bytes;
}

// A lossless file has two fields of 14 bits, each one less than the size, after the signature 0x2f.
Bytes WebpClaiming(uint32_t width, uint32_t height) {
    Bytes bytes = MakeLosslessWebp(Pattern(12, 9));
    PutLittle(bytes, Find(bytes, "VP8L") + 9, (width - 1) | (height - 1) << 14 | 1u << 28);
    return bytes;
}

Bytes ExrClaiming(ExrDesc desc, uint32_t width, uint32_t height, std::optional<uint32_t> tileSize = {}) {
    desc.width = 12;
    desc.height = 9;
    Bytes bytes = MakeExr(desc, std::vector<std::vector<float>>(3, std::vector<float>(12 * 9, 1.0f)));
    const size_t window = Find(bytes, std::string_view("dataWindow\0box2i\0", 17)) + 17 + 4;
    PutLittle(bytes, window + 8, static_cast<uint32_t>(desc.minX) + width - 1);
    PutLittle(bytes, window + 12, static_cast<uint32_t>(desc.minY) + height - 1);
    if (tileSize) {
        const size_t tiles = Find(bytes, std::string_view("tiles\0tiledesc\0", 15)) + 15 + 4;
        PutLittle(bytes, tiles, *tileSize);
        PutLittle(bytes, tiles + 4, *tileSize);
    }
    return bytes;
}

// Makes a picture of 12 x 9 that claims to be larger.
BasisFile HugeBasis() {
    BasisFile file = CompressBasis(RandomBasisPicture(12, 9, false, 1));
    file.desc.width = 16384;
    file.desc.height = 8192;
    return file;
}

// Returns the peak resident size of this process so far, in bytes.
uint64_t PeakBytes() {
    rusage usage = {};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

TEST(Hostile, HugeSizesAreRefusedByTheHeaderAlone) {
    const std::vector<uint8_t> texels(400, 9);
    const ExrDesc tiled{.tileSize = 8};
    const Sample bombs[] = {
        {"a.png", PngClaiming(60000, 60000)},
        {"b.png", PngClaiming(16384, 16384)},  // within the limits, but not in so few bytes
        {"c.png", PngClaiming(0x7fffffff, 0x7fffffff)},
        {"a.jpg", JpegClaiming(65500, 65500)},
        {"b.jpg", JpegClaiming(16384, 16384)},
        {"a.webp", WebpClaiming(16384, 16384)},
        {"a.dds", MakeDds({.width = 16384, .height = 16384, .fourCc = "DXT1"}, texels)},
        {"b.dds", MakeDds({.width = 4294967295u, .height = 4294967295u}, texels)},
        {"a.ktx2", MakeKtx2({.vkFormat = kVkRgba8, .width = 60000, .height = 60000}, texels)},
        {"b.ktx2", MakeKtx2({.vkFormat = kVkBc7, .width = 16384, .height = 16384}, texels)},
        {"c.ktx2", MakeKtx2({.vkFormat = kVkBc7,
                             .width = 16384,
                             .height = 8192,
                             .supercompression = 2,
                             .inflatedBytes = uint64_t{1} << 27},
                            texels)},
        {"d.ktx2", MakeKtx2(HugeBasis().desc, HugeBasis().level)},
        {"a.hdr", MakeHdr(60000, 60000, texels)},
        {"b.hdr", MakeHdr(16384, 8192, texels)},
        {"c.hdr", MakeHdr(4294967295u, 4294967295u, texels)},
        {"a.exr", ExrClaiming({}, 60000, 60000)},
        {"b.exr", ExrClaiming({}, 16384, 8192)},
        {"c.exr", ExrClaiming({}, 1u << 31, 1u << 31)},
        {"d.exr", ExrClaiming({.compression = Imf::DWAB_COMPRESSION}, 16384, 256)},
        {"e.exr", ExrClaiming(tiled, 16384, 8192)},
        {"f.exr", ExrClaiming(tiled, 12, 9, 0x7fffffff)},
        {"g.exr", ExrClaiming(tiled, 12, 9, 0xffffffff)},
        {"h.exr", ExrClaiming(tiled, 12, 9, 0)},
        {"i.exr", ExrClaiming(tiled, 16384, 16384, 16384)},
    };
    const uint64_t before = PeakBytes();
    for (const Sample& bomb : bombs) {
        const std::clock_t start = std::clock();
        Refusal(bomb.name, [&] { Decode(bomb.bytes, bomb.name, image::kEnvironmentLimits); });
        EXPECT_LT(std::clock() - start, 2 * CLOCKS_PER_SEC) << bomb.name;
    }
    EXPECT_LT(PeakBytes() - before, uint64_t{100} << 20);
}

TEST(Hostile, LimitsAreNamedInTheRefusal) {
    const DecodeLimits limits{.maxWidth = 11, .maxHeight = 100, .maxPixels = 1000};
    const auto refusal = [&](const Bytes& bytes) {
        return Refusal("x", [&] { image::DecodeImage8(bytes, "x", limits); });
    };
    const std::string tooWide = "x: 12 x 9 pixels exceed the limit of 11 x 100";
    EXPECT_EQ(refusal(MakePng({.width = 12, .height = 9}, Pattern(12, 9).rgba)), tooWide);
    EXPECT_EQ(refusal(MakeJpeg(JpegKind::Rgb, 12, 9, std::vector<uint8_t>(12 * 9 * 3))), tooWide);
    EXPECT_EQ(refusal(MakeLosslessWebp(Pattern(12, 9))), tooWide);
    EXPECT_EQ(refusal(MakePng({.width = 11, .height = 99}, Pattern(11, 99).rgba)),
              "x: 11 x 99 pixels exceed the limit of 1000 pixels");
    EXPECT_EQ(
        image::DecodeImage8(MakePng({.width = 10, .height = 100}, Pattern(10, 100).rgba), "x", limits).height,
        100u);
}

TEST(Hostile, ExrHeaderIsCheckedBeforeTheLibrarySeesIt) {
    const Bytes good = ExrClaiming({}, 12, 9);
    const auto refusal = [](const Bytes& bytes) {
        return Refusal("x", [&] { image::DecodeExr(bytes, "x"); });
    };
    Bytes bytes = good;
    bytes[4] = std::byte{3};
    EXPECT_NE(refusal(bytes).find("version"), std::string::npos);
    bytes = good;
    bytes[5] = std::byte{8};
    EXPECT_EQ(refusal(bytes), "x: EXR: deep pictures are not supported");
    bytes = good;
    PutLittle(bytes, Find(good, std::string_view("chlist\0", 7)) + 7, 0x7fffffff);
    EXPECT_EQ(refusal(bytes), "x: EXR: attribute 'channels' is truncated");
    bytes = good;
    bytes[Find(good, "dataWindow")] = std::byte{'D'};
    EXPECT_EQ(refusal(bytes), "x: EXR: a required attribute is missing");
    bytes = good;
    const size_t window = Find(good, std::string_view("dataWindow\0box2i\0", 17)) + 17 + 4;
    PutLittle(bytes, window, 100);
    EXPECT_EQ(refusal(bytes), "x: EXR: data window (100, 0) to (11, 8) is empty");
    PutLittle(bytes, window, 0x80000000);
    EXPECT_EQ(refusal(bytes), "x: EXR: data window (-2147483648, 0) to (11, 8) is too far out");
}

// OpenEXR reads some types by their own size, so it may see another next attribute than our check, which may
// claim gigabytes.
TEST(Hostile, ExrAttributesHaveTheSizesOfTheirTypes) {
    const Bytes good = ExrClaiming({}, 12, 9);
    const auto with = [&](std::string_view type, std::string_view value) {
        std::string attribute = "extra" + std::string(1, '\0') + std::string(type) + std::string(5, '\0');
        attribute[attribute.size() - 4] = static_cast<char>(value.size());
        const Bytes bytes = ToBytes(attribute + std::string(value));
        Bytes file = good;
        file.insert(file.begin() + 8, bytes.begin(), bytes.end());
        // The table of offsets, one chunk of all lines: right after the header
        const size_t table = Find(good, "screenWindowWidth") + 18 + 6 + 4 + 4 + 1;
        PutLittle(file, table + bytes.size(), static_cast<uint32_t>(table + bytes.size() + 8));
        return file;
    };
    const auto refusal = [&](std::string_view type, std::string_view value) {
        return Refusal("x", [&] { image::DecodeExr(with(type, value), "x"); });
    };
    const std::string zeros(200, '\0');
    for (const auto& [type, size] : std::map<std::string, size_t>{{"int", 4},
                                                                  {"double", 8},
                                                                  {"m44f", 64},
                                                                  {"preview", 8},
                                                                  {"stringvector", 8},
                                                                  {"floatvector", 12}}) {
        image::DecodeExr(with(type, zeros.substr(0, size)), "x");
        EXPECT_EQ(refusal(type, zeros.substr(0, size + 1)),
                  "x: EXR: attribute 'extra' has " + std::to_string(size + 1) + " bytes, which a " + type +
                      " of its content has not");
    }
    EXPECT_NE(refusal("preview", std::string("\x00\x40\0\0\x00\x40\0\0", 8)).find("preview"),
              std::string::npos);
    EXPECT_NE(refusal("stringvector", "\xff\xff\xff\x7f").find("stringvector"), std::string::npos);
    EXPECT_NE(refusal("chlist", zeros.substr(0, 1)).find("second list"), std::string::npos);
}

// A terminal that shows the message may act on control characters.
TEST(Hostile, RefusalsQuoteTheFileWithoutControlCharacters) {
    Bytes exr = ExrClaiming({}, 12, 9);
    // "31m" would be red
    exr[Find(exr, "dataWindow") + 4] = std::byte{0x9B};
    exr[Find(exr, std::string_view("box2i\0", 6))] = std::byte{0x7F};
    const Bytes hdr = ToBytes("#?RADIANCE\nFORMAT=\x7f\x1b[31m\n\n-Y 1 +X 1\n1234");
    for (const std::string& refusal :
         {Refusal("x", [&] { image::DecodeEnvironment(hdr, "x"); }), Refusal("x", [&] {
              Bytes cut = exr;
              cut.resize(Find(exr, "data\x9bindow") + 20);
              image::DecodeExr(cut, "x");
          })})
        EXPECT_EQ(refusal.find_first_of("\x1b\x7f\x9b"), std::string::npos) << refusal;
}

TEST(Hostile, ExrOfTooManyChannelsIsRefused) {
    // 4096 x 4096 x 100 channels: the size is fine, the sum is not.
    ExrDesc desc{.width = 1, .height = 1, .channels = {}};
    for (int i = 0; i < 100; ++i) desc.channels.push_back('c' + std::to_string(i));
    Bytes bytes = MakeExr(desc, std::vector<std::vector<float>>(100, std::vector<float>(1)));
    const size_t window = Find(bytes, std::string_view("dataWindow\0box2i\0", 17)) + 17 + 4;
    PutLittle(bytes, window + 8, 4095);
    PutLittle(bytes, window + 12, 4095);
    EXPECT_EQ(Refusal("x", [&] { image::DecodeExr(bytes, "x"); }),
              "x: EXR: 100 channels of 4096 x 4096 pixels exceed the limit");
}

}  // namespace
}  // namespace raygraph::test::hostile_test
