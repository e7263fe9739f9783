// MakeTextureLevels alone: every level against means worked out here in double, for sizes that halve evenly and
// for those that do not.
#include "renderer/gpu_scene/materials/texture_levels.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <random>

#include "renderer/graph/pass_harness.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::texture_levels_test {

namespace {

// Four numbers a texel.
struct Grid {
    Extent2D extent;
    std::vector<glm::dvec4> texels;

    const glm::dvec4& At(uint32_t x, uint32_t y) const { return texels[size_t{y} * extent.width + x]; }
    glm::dvec4 Mean() const {
        glm::dvec4 sum(0.0);
        for (const glm::dvec4& texel : texels) sum += texel;
        return sum / double(texels.size());
    }
};

double Decoded(double v) {
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}
double Encoded(double v) {
    return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
}

// The area of [t, t + 1] that texel i of n covers, of m.
double Share(uint32_t t, uint32_t i, uint32_t n, uint32_t m) {
    const double scale = double(m) / n;
    const double begin = std::max<double>(t, i * scale), end = std::min<double>(t + 1.0, (i + 1) * scale);
    return std::max(end - begin, 0.0) / scale;
}

Grid Halved(const Grid& finer) {
    Grid coarser{rhi::MipExtent(finer.extent, 1), {}};
    for (uint32_t y = 0; y < coarser.extent.height; ++y)
        for (uint32_t x = 0; x < coarser.extent.width; ++x) {
            glm::dvec4 sum(0.0);
            for (uint32_t v = 0; v < finer.extent.height; ++v) {
                const double row = Share(v, y, coarser.extent.height, finer.extent.height);
                if (row == 0.0) continue;
                for (uint32_t u = 0; u < finer.extent.width; ++u)
                    sum += row * Share(u, x, coarser.extent.width, finer.extent.width) * finer.At(u, v);
            }
            coarser.texels.push_back(sum);
        }
    return coarser;
}

glm::dvec4 Linear(TexelContent content, const glm::dvec4& stored) {
    const glm::dvec3 rgb(stored);
    if (content == TexelContent::Normals) return {glm::normalize(2.0 * rgb - 1.0), stored.w};
    if (content != TexelContent::Color) return stored;
    return {Decoded(rgb.x), Decoded(rgb.y), Decoded(rgb.z), stored.w};
}
glm::dvec4 Stored(TexelContent content, const glm::dvec4& mean) {
    const glm::dvec3 rgb(mean);
    if (content == TexelContent::Normals) return {0.5 + 0.5 * glm::normalize(rgb), mean.w};
    if (content != TexelContent::Color) return mean;
    return {Encoded(rgb.x), Encoded(rgb.y), Encoded(rgb.z), mean.w};
}

// Codes of 8 bits, brighter and bluer to the right; as normals they point up.
std::vector<float> Noise(Extent2D extent) {
    std::mt19937 random(7 * extent.width + extent.height);
    std::vector<float> values;
    for (uint32_t i = 0; i < extent.width * extent.height; ++i) {
        const uint32_t ramp = 100 * (i % extent.width) / extent.width;
        for (const uint32_t least : {ramp, 40u, 140u + ramp / 10, 5u})
            values.push_back(float(least + random() % 100) / 255.0f);
    }
    return values;
}

Grid GridOf(TexelContent content, Extent2D extent, const std::vector<float>& values) {
    Grid grid{extent, {}};
    for (size_t i = 0; i < values.size(); i += 4)
        grid.texels.push_back(
            Linear(content, glm::dvec4(values[i], values[i + 1], values[i + 2], values[i + 3])));
    return grid;
}

glm::dvec4 TexelAt(const Texels& texels, uint32_t x, uint32_t y) {
    const auto at = texels.At(x, y);
    return {at[0], at[1], at[2], at[3]};
}

class TextureLevelPass : public VulkanTest {
  protected:
    static TextureId Image(PassHarness& h, Extent2D extent, const std::vector<float>& values) {
        return h.Texture("image", extent, Format::Rgba8Unorm, values);
    }
    static TextureId Target(PassHarness& h, Extent2D extent, uint32_t levels) {
        return h.Graph().CreateTexture("target",
                                       {.extent = extent, .format = Format::Rgba8Unorm, .levels = levels});
    }
    std::vector<Texels> Levels(TexelContent content, Extent2D extent, const std::vector<float>& values) {
        return harness.RunAll([&](PassHarness& h) {
            return MakeTextureLevels(h.Graph(), Image(h, extent, values),
                                     Target(h, extent, rhi::FullMipCount(extent)), {.content = content})
                .texture;
        });
    }

    PassHarness harness{Device()};
};

constexpr Extent2D kSizes[] = {{1, 1}, {2, 2}, {7, 3}, {640, 1}, {1, 5}, {5, 5}, {97, 64}, {256, 256}};
constexpr double kHalfCode = 0.5 / 255.0 + 1e-5;

}  // namespace

TEST_F(TextureLevelPass, LevelsAreMeansOverTheAreaOfTheirTexels) {
    for (const Extent2D extent : kSizes)
        for (const TexelContent content : {TexelContent::Data, TexelContent::Color, TexelContent::Normals}) {
            const std::vector<float> values = Noise(extent);
            const std::vector<Texels> levels = Levels(content, extent, values);
            ASSERT_EQ(levels.size(), rhi::FullMipCount(extent));
            Grid expected = GridOf(content, extent, values);
            EXPECT_EQ(levels[0].values, values);
            for (size_t level = 1; level < levels.size(); ++level) {
                expected = Halved(expected);
                ASSERT_EQ(levels[level].extent, expected.extent);
                double worst = 0.0;
                for (uint32_t y = 0; y < expected.extent.height; ++y)
                    for (uint32_t x = 0; x < expected.extent.width; ++x) {
                        const glm::dvec4 difference =
                            glm::abs(TexelAt(levels[level], x, y) - Stored(content, expected.At(x, y)));
                        for (int c = 0; c < 4; ++c) worst = std::max(worst, difference[c]);
                    }
                EXPECT_LT(worst, kHalfCode) << extent.width << "x" << extent.height << " level " << level
                                            << " content " << int(content);
            }
        }
}

// No light is gained or lost, and nothing shifts: of the levels' own texels, rounded to 8 bits.
TEST_F(TextureLevelPass, EveryLevelHasTheMeanOfTheImage) {
    for (const Extent2D extent : {Extent2D{7, 3}, {640, 1}, {5, 5}, {97, 64}, {256, 256}})
        for (const TexelContent content : {TexelContent::Data, TexelContent::Color}) {
            const std::vector<float> values = Noise(extent);
            const glm::dvec4 mean = GridOf(content, extent, values).Mean();
            // As floats, before they are rounded
            const std::vector<Texels> floats = harness.RunAll([&](PassHarness& h) {
                return MakeTextureLevels(h.Graph(), Image(h, extent, values),
                                         Target(h, extent, rhi::FullMipCount(extent)), {.content = content})
                    .means->levels;
            });
            for (const Texels& level : floats) {
                const Grid grid = GridOf(TexelContent::Data, level.extent, level.values);
                for (int c = 0; c < 4; ++c) EXPECT_NEAR(grid.Mean()[c], mean[c], 2e-6) << extent.width;
            }
            const std::vector<Texels> levels = Levels(content, extent, values);
            for (const Texels& level : levels) {
                const glm::dvec4 rounded = GridOf(content, level.extent, level.values).Mean();
                const double count = double(level.extent.width) * level.extent.height;
                // Of independent roundings of at most half a code, where the curve is steepest
                const double error = 2.3 * kHalfCode * std::min(1.0, 4.0 / std::sqrt(count));
                for (int c = 0; c < 4; ++c) EXPECT_NEAR(rounded[c], mean[c], error) << extent.width;
            }
        }
}

// A white texel among clear black ones, as of a leaf: its color does not darken.
TEST_F(TextureLevelPass, ColorsOfTransparentTexelsDoNotCount) {
    const std::vector<float> values{1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    const std::vector<Texels> levels = Levels(TexelContent::TransparentColor, {2, 2}, values);
    EXPECT_NEAR(levels[1].At(0, 0)[0], 1.0f, 1.5f / 255.0f);
    EXPECT_NEAR(levels[1].At(0, 0)[3], 0.25f, kHalfCode);
    const std::vector<Texels> opaque = Levels(TexelContent::Color, {2, 2}, values);
    EXPECT_NEAR(opaque[1].At(0, 0)[0], Encoded(0.25), kHalfCode);
    // Where all are clear, their colors do
    const std::vector<float> clear{1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    EXPECT_NEAR(Levels(TexelContent::TransparentColor, {2, 2}, clear)[1].At(0, 0)[0], Encoded(0.5),
                1.5f / 255.0f);
}

TEST_F(TextureLevelPass, SmallerTargetHasTheLowerLevels) {
    const Extent2D extent{13, 6};
    const std::vector<float> values = Noise(extent);
    const std::vector<Texels> all = Levels(TexelContent::Color, extent, values);
    for (const uint32_t levelCount : {1u, 2u}) {
        const std::vector<Texels> some = harness.RunAll([&](PassHarness& h) {
            return MakeTextureLevels(h.Graph(), Image(h, extent, values), Target(h, {3, 1}, levelCount),
                                     {.content = TexelContent::Color, .firstLevel = 2})
                .texture;
        });
        ASSERT_EQ(some.size(), levelCount);
        for (uint32_t level = 0; level < levelCount; ++level)
            EXPECT_EQ(some[level].values, all[level + 2].values);
    }
    const auto other = [&] {
        harness.Run([&](PassHarness& h) {
            return MakeTextureLevels(h.Graph(), Image(h, extent, values), Target(h, {3, 2}, 1),
                                     {.firstLevel = 2})
                .texture;
        });
    };
    EXPECT_STREQ(ErrorOf(other).what(),
                 "MakeTextureLevels: an image of 13x6 texels has no level 2 of 3x2 texels");
}

// Waves of slopes +-s in x: their mean normal is as long as the cosine, and slopes have the variance that
// widens alpha^2 twice.
TEST_F(TextureLevelPass, RoughnessGrowsByTheVarianceOfTheNormals) {
    const Extent2D extent{4, 4}, fine{8, 8};
    const double tilt = 0.2, scale = 0.5, factor = 0.8, rough = 102.0 / 255.0;
    std::vector<float> normals, roughness;
    for (uint32_t i = 0; i < 64; ++i) {
        const double x = (i % 2 == 0 ? 1.0 : -1.0) * std::sin(tilt);
        for (const double value : {0.5 + 0.5 * x, 0.5, 0.5 + 0.5 * std::cos(tilt), 1.0})
            normals.push_back(float(std::round(255.0 * value) / 255.0));
    }
    for (uint32_t i = 0; i < 16; ++i)
        for (const double value : {0.2, rough, 0.6, 0.8}) roughness.push_back(float(value));
    const auto run = [&](double normalScale, const std::vector<float>& map) {
        return harness.RunAll([&](PassHarness& h) {
            const TextureLevels bent = MakeTextureLevels(h.Graph(), Image(h, fine, map), Target(h, fine, 4),
                                                         {.content = TexelContent::Normals});
            const RoughnessWidening widening{
                .normals = *bent.means, .normalScale = float(normalScale), .roughnessFactor = float(factor)};
            return MakeTextureLevels(h.Graph(), Image(h, extent, roughness), Target(h, extent, 3),
                                     {.widening = widening})
                .texture;
        });
    };
    const Grid unit = GridOf(TexelContent::Normals, fine, normals);
    const double size = glm::length(glm::dvec3(unit.Mean()));
    const double variance = scale * scale * (1.0 - size) / size;
    const double alpha = factor * factor * rough * rough;
    const double wider = std::pow(alpha * alpha + 2.0 * variance, 0.25) / factor;
    ASSERT_GT(wider, 1.1 * rough);
    const std::vector<Texels> levels = run(scale, normals);
    EXPECT_EQ(levels[0].values,
              testing::DecodeTexels(testing::EncodeTexels(roughness, extent, Format::Rgba8Unorm), extent,
                                    Format::Rgba8Unorm)
                  .values);
    for (size_t level = 1; level < 3; ++level)
        for (uint32_t x = 0; x < levels[level].extent.width; ++x) {
            EXPECT_NEAR(levels[level].At(x, 0)[1], wider, kHalfCode + 1e-4) << level;
            EXPECT_NEAR(levels[level].At(x, 0)[0], 0.2, kHalfCode);
            EXPECT_NEAR(levels[level].At(x, 0)[2], 0.6, kHalfCode);
        }
    // Roughness 1 of what the factor allows is the most; a flat map changes nothing
    EXPECT_EQ(run(1e3, normals)[1].At(0, 0)[1], 1.0f);
    std::vector<float> flat;
    for (uint32_t i = 0; i < 64; ++i) flat.insert(flat.end(), {0.5f, 0.5f, 1.0f, 1.0f});
    EXPECT_NEAR(run(scale, flat)[2].At(0, 0)[1], rough, kHalfCode);
}

// Of a normal map of half the size nothing is averaged in level 1 of the roughness.
TEST_F(TextureLevelPass, SmallNormalMapsWidenOnlyTheLevelsThatAverageThem) {
    std::vector<float> normals, roughness(64 * 4, 0.4f);
    for (uint32_t i = 0; i < 16; ++i)
        for (const float value : {i % 2 == 0 ? 0.7f : 0.3f, 0.5f, 0.95f, 1.0f}) normals.push_back(value);
    const std::vector<Texels> levels = harness.RunAll([&](PassHarness& h) {
        const TextureLevels bent = MakeTextureLevels(
            h.Graph(), Image(h, {4, 4}, normals), Target(h, {4, 4}, 3), {.content = TexelContent::Normals});
        return MakeTextureLevels(h.Graph(), Image(h, {8, 8}, roughness), Target(h, {8, 8}, 4),
                                 {.widening = RoughnessWidening{.normals = *bent.means}})
            .texture;
    });
    EXPECT_NEAR(levels[1].At(0, 0)[1], 0.4f, kHalfCode);
    EXPECT_GT(levels[2].At(0, 0)[1], 0.5f);
    EXPECT_GT(levels[3].At(0, 0)[1], 0.5f);
}

}  // namespace raygraph::testing::texture_levels_test
