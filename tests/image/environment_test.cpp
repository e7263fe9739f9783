#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "renderer/image/exr.h"
#include "tests/image/image_files.h"
#include "tests/support/reference_assets.h"

namespace raygraph::test {
namespace {

using image::DecodeEnvironment;
using image::Environment;
using image::ImageF;

std::string ExrRefusal(const Bytes& bytes) {
    return Refusal("x.exr", [&] { DecodeEnvironment(bytes, "x.exr"); });
}

// Smooth planes of whole numbers up to 2000, exact in half.
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

// R, G, B planes and an alpha of 1 as texels.
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
    double tolerance;  // Of the greatest value; 0: exact.
};

class EnvironmentOfCoding : public testing::TestWithParam<Coding> {};

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
    testing::Values(
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
        const ExrDesc desc{.minX = -37, .minY = 1001, .width = 10, .height = 20, .tileSize = tileSize};
        const auto planes = Planes(3, 10, 20);
        EXPECT_EQ(DecodeEnvironment(MakeExr(desc, planes), "x.exr").image.rgba, Interleaved(planes));
    }
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

// With the asset collection: maps made by other programs.
class EnvironmentAssets : public testing::Test {
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
}  // namespace raygraph::test
