#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "renderer/image/exr.h"
#include "tests/image/image_files.h"
#include "tests/support/reference_assets.h"

namespace raygraph::test::environment_test {
namespace {

using image::DecodeEnvironment;
using image::Environment;
using image::ImageF;

std::string ExrRefusal(const Bytes& bytes) {
    return Refusal("x.exr", [&] { DecodeEnvironment(bytes, "x.exr"); });
}

// Makes smooth planes of whole numbers up to 2000, which are exact in half floats.
std::vector<std::vector<float>> Planes(size_t count, uint32_t width, uint32_t height) {
    std::vector<std::vector<float>> planes(count);
    for (size_t c = 0; c < count; ++c) {
        for (uint32_t i = 0; i < width * height; ++i) {
            const double phase = 0.07 * (i % width) + 0.05 * static_cast<double>((c + 1) * (i / width));
            planes[c].push_back(static_cast<float>(std::floor(1000.0 + 1000.0 * std::sin(phase))));
        }
    }
    return planes;
}

// Interleaves R, G and B planes with an alpha of 1.
std::vector<float> Interleaved(const std::vector<std::vector<float>>& planes) {
    std::vector<float> rgba;
    for (size_t i = 0; i < planes[0].size(); ++i) {
        for (size_t c = 0; c < 4; ++c) rgba.push_back(c < planes.size() ? planes[c][i] : 1.0f);
    }
    return rgba;
}

struct Coding {
    Imf::PixelType type;
    Imf::Compression compression;
    uint32_t tileSize;
    double tolerance;  // relative to the largest value; 0: exact
};

class EnvironmentOfCoding : public ::testing::TestWithParam<Coding> {};

TEST_P(EnvironmentOfCoding, ValuesAreRead) {
    const Coding& coding = GetParam();
    const ExrDesc desc{.width = 70,
                       .height = 41,
                       .type = coding.type,
                       .compression = coding.compression,
                       .tileSize = coding.tileSize};
    const auto planes = Planes(3, 70, 41);
    const ImageF image = DecodeEnvironment(MakeExr(desc, planes), "x.exr").image;
    EXPECT_EQ(image.width, 70u);
    EXPECT_EQ(image.height, 41u);
    const auto expected = Interleaved(planes);
    ASSERT_EQ(image.rgba.size(), expected.size());
    double greatest = 0.0;
    for (size_t i = 0; i < expected.size(); ++i) {
        greatest = std::max(greatest, std::abs(double{image.rgba[i]} - expected[i]));
    }
    EXPECT_LE(greatest, coding.tolerance * 2000.0);
}

INSTANTIATE_TEST_SUITE_P(
    Exr, EnvironmentOfCoding,
    ::testing::Values(
        Coding{Imf::FLOAT, Imf::NO_COMPRESSION, 0, 0}, Coding{Imf::HALF, Imf::RLE_COMPRESSION, 0, 0},
        Coding{Imf::FLOAT, Imf::ZIPS_COMPRESSION, 0, 0}, Coding{Imf::UINT, Imf::ZIP_COMPRESSION, 0, 0},
        Coding{Imf::HALF, Imf::PIZ_COMPRESSION, 0, 0}, Coding{Imf::FLOAT, Imf::PXR24_COMPRESSION, 0, 1e-4},
        Coding{Imf::HALF, Imf::B44_COMPRESSION, 0, 0.05}, Coding{Imf::HALF, Imf::B44A_COMPRESSION, 0, 0.05},
        Coding{Imf::FLOAT, Imf::DWAA_COMPRESSION, 0, 0.1}, Coding{Imf::HALF, Imf::DWAB_COMPRESSION, 0, 0.1},
        Coding{Imf::FLOAT, Imf::ZIP_COMPRESSION, 16, 0}, Coding{Imf::HALF, Imf::NO_COMPRESSION, 64, 0}));

TEST(Environment, TallPictureIsReadOverManyChunks) {
    const auto planes = Planes(3, 3, 600);
    const ImageF image = DecodeEnvironment(MakeExr({.width = 3, .height = 600}, planes), "x.exr").image;
    EXPECT_EQ(image.rgba, Interleaved(planes));
}

TEST(Environment, DataWindowMayLieAnywhere) {
    for (const uint32_t tileSize : {0u, 8u}) {
        const ExrDesc desc{.minX = -37,
                           .minY = 1001,
                           .width = 10,
                           .height = 20,
                           .tileSize = tileSize,
                           .picture = {{-37, 1001, -28, 1020}}};
        const auto planes = Planes(3, 10, 20);
        EXPECT_EQ(DecodeEnvironment(MakeExr(desc, planes), "x.exr").image.rgba, Interleaved(planes));
    }
}

// Expects pixel (x, y) of the planes at (x + right, y + down) in a picture of the size of desc.picture, and
// black elsewhere.
void ExpectPlaced(const ImageF& image, const std::vector<std::vector<float>>& planes, const ExrDesc& desc,
                  int right, int down) {
    const auto& box = *desc.picture;
    const int columns = box[2] - box[0] + 1, rows = box[3] - box[1] + 1;
    ASSERT_EQ(image.width, static_cast<uint32_t>(columns));
    ASSERT_EQ(image.height, static_cast<uint32_t>(rows));
    const auto width = static_cast<int>(desc.width), height = static_cast<int>(desc.height);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const int column = x - right, row = y - down;
            const bool isThere = column >= 0 && column < width && row >= 0 && row < height;
            const auto source = static_cast<size_t>(row * width + column);
            for (size_t c = 0; c < 3; ++c)
                ASSERT_EQ(image.rgba[4 * static_cast<size_t>(y * columns + x) + c],
                          isThere ? planes[c][source] : 0.0f)
                    << x << ", " << y;
        }
}

TEST(Environment, CroppedPictureIsPlacedInItsDisplayWindowAndBlackBeyond) {
    const auto planes = Planes(3, 5, 3);
    ExrDesc desc{.minX = 4, .minY = 2, .width = 5, .height = 3, .picture = {{0, 0, 15, 7}}};
    ExpectPlaced(DecodeEnvironment(MakeExr(desc, planes), "x.exr").image, planes, desc, 4, 2);
    desc.picture = {{-6, -1, 9, 6}};
    ExpectPlaced(DecodeEnvironment(MakeExr(desc, planes), "x.exr").image, planes, desc, 10, 3);
}

TEST(Environment, OverscanIsCutOffAndNotLookedAt) {
    auto planes = Planes(3, 8, 6);
    planes[1][0] = std::nanf("");
    const ExrDesc desc{.minX = -1, .minY = -2, .width = 8, .height = 6, .picture = {{0, 0, 3, 2}}};
    ExpectPlaced(DecodeEnvironment(MakeExr(desc, planes), "x.exr").image, planes, desc, -1, -2);
    // The data window reaches beyond the left and the bottom, and leaves the right and the top black
    const ExrDesc both{.minX = -4, .minY = 1, .width = 8, .height = 6, .picture = {{0, 0, 7, 3}}};
    ExpectPlaced(DecodeEnvironment(MakeExr(both, planes), "x.exr").image, planes, both, -4, 1);
}

TEST(Environment, PartThatCannotBePlacedIsRefused) {
    const auto planes = Planes(3, 2, 2);
    const ExrDesc outside{.minX = 8, .minY = 3, .width = 2, .height = 2, .picture = {{0, 0, 7, 3}}};
    EXPECT_EQ(ExrRefusal(MakeExr(outside, planes)),
              "x.exr: EXR: 2 x 2 pixels from 8, 3 on are outside of its picture of 8 x 4");
    const ExrDesc bomb{.width = 2, .height = 2, .picture = {{0, 0, 16383, 8191}}};
    EXPECT_EQ(ExrRefusal(MakeExr(bomb, planes)),
              "x.exr: EXR: 2 x 2 pixels are too few for a picture of 16384 x 8192");
    const ExrDesc huge{.width = 2, .height = 2, .picture = {{-(1 << 29), -(1 << 29), 1 << 29, 1 << 29}}};
    EXPECT_EQ(ExrRefusal(MakeExr(huge, planes)),
              "x.exr: 1073741825 x 1073741825 pixels exceed the limit of 16384 x 16384");
}

constexpr std::array<float, 8> kAces{0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.077f, 0.32168f, 0.33767f};

TEST(Environment, OtherPrimariesAreConvertedToRec709) {
    // The picture has a pixel of each primary, and a white one
    const std::vector<std::vector<float>> planes = {{1, 0, 0, 2}, {0, 1, 0, 2}, {0, 0, 1, 2}};
    const Bytes bytes = MakeExr({.width = 4, .chromaticities = kAces}, planes);
    const Environment environment = DecodeEnvironment(bytes, "x.exr");
    // The published matrix from ACES2065-1 to linear Rec. 709 by the Bradford transform; colors out of the
    // gamut have a negative part, which becomes 0
    const std::vector<float> expected = {2.521686f, 0, 0,         1, 0, 1.372719f, 0, 1,
                                         0,         0, 1.168353f, 1, 2, 2,         2, 1};
    ASSERT_EQ(environment.image.rgba.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i)
        EXPECT_NEAR(environment.image.rgba[i], expected[i], 2e-5f) << i;
    ASSERT_EQ(environment.warnings.size(), 1u);
    EXPECT_EQ(environment.warnings[0], "x.exr: 6 negative values set to 0, the first at pixel (0, 0)");
    // A color within the gamut is converted by rows of the same matrix
    const std::vector<std::vector<float>> inside = {{0.5f}, {0.4f}, {0.3f}};
    const ImageF image = DecodeEnvironment(MakeExr({.chromaticities = kAces}, inside), "x.exr").image;
    EXPECT_NEAR(image.rgba[0], 0.5f * 2.521686f - 0.4f * 1.134131f - 0.3f * 0.387555f, 2e-5f);
    EXPECT_NEAR(image.rgba[1], -0.5f * 0.276480f + 0.4f * 1.372719f - 0.3f * 0.096239f, 2e-5f);
    EXPECT_NEAR(image.rgba[2], -0.5f * 0.015378f - 0.4f * 0.152975f + 0.3f * 1.168353f, 2e-5f);
}

TEST(Environment, Rec709AndLuminanceKeepTheirBits) {
    const auto planes = Planes(3, 9, 4);
    const ExrDesc rec709{.width = 9,
                         .height = 4,
                         .chromaticities = {{0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f}}};
    EXPECT_EQ(DecodeEnvironment(MakeExr(rec709, planes), "x.exr").image.rgba, Interleaved(planes));
    const ExrDesc gray{.width = 9, .height = 4, .channels = {"Y"}, .chromaticities = kAces};
    EXPECT_EQ(DecodeEnvironment(MakeExr(gray, std::span(planes).first(1)), "x.exr").image.rgba,
              Interleaved({planes[0], planes[0], planes[0]}));
}

TEST(Environment, PrimariesThatSpanNoColorsAreRefused) {
    const auto planes = Planes(3, 1, 1);
    const float infinity = std::numeric_limits<float>::infinity();
    const std::array<float, 8> broken[] = {
        {0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f},
        {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3f, 0.0f},
        {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, std::nanf(""), 0.3f},
        {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, infinity, 0.31f, 0.33f},
    };
    for (const std::array<float, 8>& chromaticities : broken) {
        const Bytes bytes = MakeExr({.chromaticities = chromaticities}, planes);
        EXPECT_NE(ExrRefusal(bytes).find("hromaticities"), std::string::npos) << ExrRefusal(bytes);
    }
}

TEST(Environment, EnvmapAttributeSaysWhatKindOfMapItIs) {
    constexpr int kLatitudeLongitude = 0, kCube = 1;
    const auto planes = Planes(3, 6, 36);
    const ExrDesc cube{.width = 6, .height = 36, .envmap = kCube};
    EXPECT_EQ(ExrRefusal(MakeExr(cube, planes)),
              "x.exr: EXR: is a cube map by its envmap attribute; an environment is "
              "a latitude-longitude map");
    // OpenEXR defines such a map by its data window
    const ExrDesc sphere{.minX = 3,
                         .minY = 1,
                         .width = 6,
                         .height = 36,
                         .picture = {{0, 0, 99, 49}},
                         .envmap = kLatitudeLongitude};
    const ImageF image = DecodeEnvironment(MakeExr(sphere, planes), "x.exr").image;
    EXPECT_EQ(image.width, 6u);
    EXPECT_EQ(image.rgba, Interleaved(planes));
}

TEST(Environment, AlphaIsKeptAndLuminanceIsGray) {
    const auto planes = Planes(4, 5, 4);
    const Bytes rgba = MakeExr({.width = 5, .height = 4, .channels = {"R", "G", "B", "A"}}, planes);
    EXPECT_EQ(DecodeEnvironment(rgba, "x.exr").image.rgba, Interleaved(planes));
    const auto gray = Planes(1, 5, 4);
    const Bytes y = MakeExr({.width = 5, .height = 4, .channels = {"Y"}}, gray);
    EXPECT_EQ(DecodeEnvironment(y, "x.exr").image.rgba, Interleaved({gray[0], gray[0], gray[0]}));
}

TEST(Environment, ValuesAboveTheHalfRangeAreKept) {
    const std::vector<std::vector<float>> planes = {{109568.0f}, {1e30f}, {65505.0f}};
    EXPECT_EQ(DecodeEnvironment(MakeExr({}, planes), "x.exr").image.rgba,
              (std::vector<float>{109568.0f, 1e30f, 65505.0f, 1.0f}));
}

TEST(Environment, NonFiniteTexelIsRefusedByItsPlace) {
    auto planes = Planes(3, 7, 5);
    planes[1][2 * 7 + 3] = std::nanf("");
    EXPECT_EQ(ExrRefusal(MakeExr({.width = 7, .height = 5}, planes)), "x.exr: pixel (3, 2) is NaN");
    planes[1][2 * 7 + 3] = -std::numeric_limits<float>::infinity();
    EXPECT_EQ(ExrRefusal(MakeExr({.width = 7, .height = 5}, planes)), "x.exr: pixel (3, 2) is infinite");
}

TEST(Environment, NegativeTexelBecomesZeroWithAWarning) {
    auto planes = Planes(3, 7, 5);
    planes[0][8] = -1.0f;
    planes[2][30] = -2.0f;
    const Environment environment = DecodeEnvironment(MakeExr({.width = 7, .height = 5}, planes), "x.exr");
    planes[0][8] = planes[2][30] = 0.0f;
    EXPECT_EQ(environment.image.rgba, Interleaved(planes));
    ASSERT_EQ(environment.warnings.size(), 1u);
    EXPECT_EQ(environment.warnings[0], "x.exr: 2 negative values set to 0, the first at pixel (1, 1)");
}

TEST(Environment, MissingColorIsRefusedWithWhatThereIs) {
    const auto planes = Planes(3, 2, 2);
    const Bytes bytes = MakeExr({.width = 2, .height = 2, .channels = {"L.R", "L.G", "Z"}}, planes);
    EXPECT_EQ(ExrRefusal(bytes), "x.exr: EXR: no R, G, B and no Y among its channels: L.G L.R Z");
    const Bytes chroma = MakeExr({.width = 2, .height = 2, .channels = {"Y", "RY", "BY"}}, planes);
    EXPECT_EQ(ExrRefusal(chroma),
              "x.exr: EXR: luminance with chroma (Y, RY, BY) is not supported, only R, G, B or Y alone");
}

TEST(Environment, SubsampledAndMultiPartFilesAreRefused) {
    const std::vector<std::vector<float>> planes = {std::vector<float>(16), std::vector<float>(4)};
    const ExrDesc desc{.width = 4, .height = 4, .channels = {"Y", "Z"}, .sampling = 2};
    EXPECT_EQ(ExrRefusal(MakeExr(desc, planes)),
              "x.exr: EXR: channel 'Z' is subsampled, which is not supported");
    EXPECT_EQ(ExrRefusal(MakeMultiPartExr()), "x.exr: EXR: multi-part files are not supported");
}

TEST(Environment, OtherFilesAreRefusedByTheirContent) {
    EXPECT_EQ(Refusal("x", [] { DecodeEnvironment(ToBytes("\xff\xd8\xff\xe0"), "x"); }),
              "x: is a JPEG; an environment is Radiance HDR or OpenEXR");
    EXPECT_EQ(Refusal("x", [] { DecodeEnvironment({}, "x"); }), "x: the file is empty");
}

// Uses maps by other programs, from the asset collection.
class EnvironmentAssets : public ::testing::Test {
  protected:
    void SetUp() override {
        RAYGRAPH_SKIP_WITHOUT_ASSETS();
        m_folder = *ReferenceAssets();
    }
    ImageF Read(const char* name) const {
        return image::ReadEnvironment(m_folder / "scenes/env" / name).image;
    }
    const std::filesystem::path& Folder() const { return m_folder; }

  private:
    std::filesystem::path m_folder;
};

TEST_F(EnvironmentAssets, AxesMapHasItsColorsWhereTheConventionSays) {
    const ImageF image = Read("env_axes.exr");
    const auto texel = [&](double x, double y, double z) {
        const double u = 0.5 + std::atan2(z, x) / (2 * M_PI), v = std::acos(y) / M_PI;
        const auto column = static_cast<size_t>(u * image.width) % image.width;
        const auto row = std::min(static_cast<size_t>(v * image.height), size_t{image.height} - 1);
        const float* rgba = image.rgba.data() + 4 * (row * image.width + column);
        return std::array{rgba[0], rgba[1], rgba[2]};
    };
    const auto brightest = [](const std::array<float, 3>& rgb) {
        return std::max_element(rgb.begin(), rgb.end()) - rgb.begin();
    };
    EXPECT_NEAR(texel(1, 0, 0)[0], 1.0f, 0.02f);
    EXPECT_EQ(brightest(texel(1, 0, 0)), 0);
    EXPECT_NEAR(texel(0, 1, 0)[1], 1.0f, 0.02f);
    EXPECT_EQ(brightest(texel(0, 1, 0)), 1);
    EXPECT_NEAR(texel(0, 0, 1)[2], 1.0f, 0.02f);
    EXPECT_EQ(brightest(texel(0, 0, 1)), 2);
    EXPECT_NEAR(texel(-1, 0, 0)[0], 0.25f, 0.02f);
    EXPECT_NEAR(texel(0, -1, 0)[1], 0.25f, 0.02f);
    EXPECT_NEAR(texel(0, 0, -1)[2], 0.25f, 0.02f);
}

TEST_F(EnvironmentAssets, SunAboveTheHalfRangeIsKept) {
    const ImageF image = Read("qwantani_afternoon_puresky_1k.hdr");
    EXPECT_EQ(image.width, 1024u);
    EXPECT_EQ(image.height, 512u);
    EXPECT_EQ(*std::max_element(image.rgba.begin(), image.rgba.end()), 109568.0f);
}

TEST_F(EnvironmentAssets, EveryMapIsRead) {
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(Folder() / "scenes/env")) {
        const ImageF image = image::ReadEnvironment(entry.path()).image;
        EXPECT_EQ(image.width, 2 * image.height) << entry.path();
        EXPECT_GT(*std::max_element(image.rgba.begin(), image.rgba.end()), 0.5f) << entry.path();
        ++count;
    }
    EXPECT_GE(count, 5u);
}

TEST_F(EnvironmentAssets, EveryReferenceImageIsRead) {
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(Folder() / "references")) {
        if (entry.path().extension() != ".exr") continue;
        const image::ExrImage image = image::ReadExr(entry.path());
        EXPECT_GE(image.channels.size(), 3u) << entry.path();
        ++count;
    }
    EXPECT_GE(count, 5u);
}

}  // namespace
}  // namespace raygraph::test::environment_test
