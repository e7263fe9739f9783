// The passes that compare two pictures, with hand-made texels; and the numbers of a viewport.
#include <gmock/gmock.h>
#include <array>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>
#include <string>

#include "base/error.h"
#include "passes/compare.h"
#include "passes/flip.h"
#include "passes/overlay.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/scene/animation/deform.h"
#include "tests/support/option_rows.h"
#include "tests/support/vulkan_test.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::compare_test {

namespace {

class Compare : public VulkanTest {
  protected:
    PassHarness harness{Device()};
};

// Gray values 0 ... 1 as rgba, one a texel.
std::vector<float> Grays(const std::vector<float>& values) {
    std::vector<float> texels;
    for (const float value : values) texels.insert(texels.end(), {value, value, value, 1.0f});
    return texels;
}

std::vector<float> Ramp(size_t count, float from, float step) {
    std::vector<float> values(count);
    for (size_t i = 0; i < count; ++i) values[i] = from + step * float(i);
    return values;
}

}  // namespace

TEST_F(Compare, Wipe_ShowsOnePictureOnEitherSideOfTheLine) {
    const auto wiped = [&](float position) {
        const Texels texels = harness.Run([&](PassHarness& h) {
            return passes::Wipe(h.Graph(), h.Texture("left", {8, 2}, Format::Rgba8Unorm, {0, 0, 0, 1}),
                                h.Texture("right", {8, 2}, Format::Rgba8Unorm, {0, 0, 1, 1}), position);
        });
        std::string row;
        for (uint32_t x = 0; x < 8; ++x) {
            const auto texel = texels.At(x, 1);
            row += texel[0] > 0.5f ? '|' : texel[2] > 0.5f ? 'R' : 'L';
        }
        return row;
    };
    EXPECT_EQ(wiped(0.5f), "LLLL|RRR");
    EXPECT_EQ(wiped(0.25f), "LL|RRRRR");
    EXPECT_EQ(wiped(0.0f), "RRRRRRRR");
    EXPECT_EQ(wiped(1.0f), "LLLLLLLL");
    EXPECT_EQ(wiped(-3.0f), "RRRRRRRR");
    EXPECT_EQ(wiped(std::numeric_limits<float>::quiet_NaN()), "RRRRRRRR");
}

TEST_F(Compare, SideBySide_ShowsAllOfBothAtHalfTheSize) {
    const std::vector<float> left = Grays(Ramp(16, 0.0f, 4.0f / 255.0f));
    const Texels texels = harness.Run([&](PassHarness& h) {
        return passes::SideBySide(h.Graph(), h.Texture("left", {4, 4}, Format::Rgba8Unorm, left),
                                  h.Texture("right", {4, 4}, Format::Rgba8Unorm, {1, 1, 1, 1}));
    });
    // Means of 2 x 2: rows 0 and 1 of the left picture in row 1
    EXPECT_NEAR(texels.At(0, 1)[0] * 255.0f, (0 + 4 + 16 + 20) / 4.0f, 0.51f);
    EXPECT_NEAR(texels.At(1, 2)[0] * 255.0f, (40 + 44 + 56 + 60) / 4.0f, 0.51f);
    EXPECT_EQ(texels.At(2, 1)[0], 1.0f);
    EXPECT_EQ(texels.At(3, 2)[0], 1.0f);
    EXPECT_LT(texels.At(2, 0)[0], 0.2f);
    EXPECT_LT(texels.At(0, 3)[0], 0.2f);
}

TEST_F(Compare, RelativeErrorAndDifference_AreWhatTheirFormulasSay) {
    const std::vector<float> reference{1, 1, 1, 1, 0, 0, 0, 1, 0, 2, 0, 1};
    const std::vector<float> test{1.5f, 1.5f, 1.5f, 1, 0.02f, 0.02f, 0.02f, 1, 0, 1, 0, 1};
    const auto pictures = [&](PassHarness& h) {
        return std::pair(h.Texture("reference", {3, 1}, Format::Rgba32Float, reference),
                         h.Texture("test", {3, 1}, Format::Rgba32Float, test));
    };
    const Texels error = harness.Run([&](PassHarness& h) {
        const auto [a, b] = pictures(h);
        return passes::RelativeError(h.Graph(), a, b, 0.01f);
    });
    EXPECT_NEAR(error.At(0, 0)[0], 0.5f, 1e-5f);
    EXPECT_NEAR(error.At(1, 0)[0], 2.0f, 1e-5f);
    EXPECT_NEAR(error.At(2, 0)[0], 0.5f, 1e-5f);
    const Texels difference = harness.Run([&](PassHarness& h) {
        const auto [a, b] = pictures(h);
        return passes::Difference(h.Graph(), a, b).difference;
    });
    EXPECT_EQ(difference.At(0, 0)[0], 0.5f);
    EXPECT_EQ(difference.At(2, 0)[1], 1.0f);
    EXPECT_EQ(difference.At(2, 0)[0], 0.0f);
    const Texels luminance = harness.Run([&](PassHarness& h) {
        const auto [a, b] = pictures(h);
        return passes::Difference(h.Graph(), a, b).luminance;
    });
    EXPECT_NEAR(luminance.At(2, 0)[0], 0.7152f, 1e-5f);
}

TEST_F(Compare, NumbersOfAMap_AreItsMeanAndItsGreatest) {
    const Extent2D extent{37, 21};
    std::vector<float> values = Ramp(size_t{37} * 21, 0.0f, 0.001f);
    std::swap(values[5], values.back());
    Renderer& renderer = harness.Graph();
    Readback groups;
    harness.Run([&](PassHarness& h) {
        const TextureId map = h.Texture("map", extent, Format::R32Float, values);
        groups = renderer.ReadBack(passes::ReduceBlocks(renderer, map));
        EXPECT_THROW(passes::StatisticsOf(groups, extent), Error);
        return map;
    });
    const passes::MapStatistics numbers = passes::StatisticsOf(groups, extent);
    EXPECT_NEAR(numbers.mean, 0.5 * 0.001 * (37 * 21 - 1), 1e-5);
    EXPECT_EQ(numbers.maximum, values[5]);
    EXPECT_THROW(passes::StatisticsOf(groups, {64, 64}), Error);
}

// Two samples of 1 and 3 in each pixel, and a third of 5 in the upper row.
TEST_F(Compare, RelativeSquaredError_TellsTheReferencesNoiseByTheSamplesOfEachPixel) {
    constexpr Extent2D kExtent{2, 2};
    passes::Accumulation samples("samples");
    const auto run = [&](bool isNoise) {
        samples.Reset(passes::ResetCause::Start);
        return harness.Run([&](PassHarness& h) {
            const auto sample = [&](const char* name, Extent2D extent, float value) {
                return h.Texture(name, extent, Format::Rgba32Float, {value, value, value, 1});
            };
            static_cast<void>(passes::Accumulate(h.Graph(), sample("first", kExtent, 1.0f), samples, true));
            static_cast<void>(passes::Accumulate(h.Graph(), sample("second", kExtent, 3.0f), samples, true));
            const passes::AccumulatedIds ids = passes::AccumulateTile(
                h.Graph(), sample("third", {2, 1}, 5.0f), kExtent, {0, 0, 2, 1}, samples, true);
            const passes::SquaredErrorIds errors = passes::RelativeSquaredError(
                h.Graph(), sample("test", kExtent, 2.5f), ids, samples.Declared());
            return isNoise ? errors.noise : errors.error;
        });
    };
    const Texels error = run(false), noise = run(true);
    EXPECT_NEAR(error.At(1, 0)[0], 0.25f / 9.01f, 1e-6f);
    EXPECT_NEAR(noise.At(1, 0)[0], 4.0f / 3.0f / 9.01f, 1e-6f);
    EXPECT_NEAR(error.At(0, 1)[0], 0.25f / 4.01f, 1e-6f);
    EXPECT_NEAR(noise.At(0, 1)[0], 2.0f / 2.0f / 4.01f, 1e-6f);
    EXPECT_THROW(harness.Run([&](PassHarness& h) {
        return passes::RelativeSquaredError(h.Graph(),
                                            h.Texture("test", kExtent, Format::Rgba32Float, {1, 1, 1, 1}),
                                            passes::StoredAccumulation(h.Graph(), samples, kExtent, true), {})
            .error;
    }),
                 Error)
        << "there is no sample";
}

TEST_F(Compare, Flicker_IsTheVarianceOverPicturesByTheirShares) {
    const auto add = [&](float value, float weight) {
        const Texels flicker = harness.Run([&](PassHarness& h) {
            return passes::Flicker(
                h.Graph(), h.Texture("picture", {3, 2}, Format::Rgba32Float, {value, value, value, 1}),
                h.Graph().Persist("moments", {{3, 2}, Format::Rg32Float}), weight);
        });
        return flicker.At(2, 1)[0];
    };
    add(7.0f, 1.0f);
    EXPECT_EQ(add(1.0f, 1.0f), 0.0f) << "it begins anew";
    EXPECT_NEAR(add(3.0f, 0.5f), 1.0f / 4.01f, 1e-5f);
    EXPECT_NEAR(add(2.0f, 1.0f / 3.0f), 2.0f / 3.0f / 4.01f, 1e-5f);
    for (int i = 0; i < 40; ++i) add(2.0f, 0.5f);
    EXPECT_NEAR(add(2.0f, 0.5f), 0.0f, 1e-5f) << "the first are forgotten";
}

TEST_F(Compare, Heat_IsLighterTheGreaterTheValue) {
    std::vector<float> values = Ramp(32, 0.0f, 1.0f / 31.0f);
    values.push_back(std::numeric_limits<float>::quiet_NaN());
    const Texels texels = harness.Run([&](PassHarness& h) {
        return passes::Heat(h.Graph(), h.Texture("map", {33, 1}, Format::R32Float, values), 1.0f);
    });
    const auto lightness = [&](uint32_t x) {
        const auto c = texels.At(x, 0);
        return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
    };
    for (uint32_t x = 1; x < 32; ++x) EXPECT_GT(lightness(x), lightness(x - 1)) << x;
    EXPECT_EQ(lightness(32), lightness(0));
    EXPECT_GT(lightness(31), 0.8f);
}

TEST_F(Compare, Overlay_ShowsWhatIsDoneOverWhatIsCoarse) {
    passes::TileCursor cursor;
    cursor.Advance({4, 4}, {0, 0, 4, 1});
    cursor.Advance({4, 4}, {0, 1, 2, 2});
    const Texels texels = harness.Run([&](PassHarness& h) {
        return passes::Overlay(h.Graph(), h.Texture("coarse", {1, 1}, Format::Rgba32Float, {0.25f, 0, 0, 1}),
                               h.Texture("fine", {4, 4}, Format::Rgba32Float, {8, 0, 0, 1}), cursor);
    });
    std::string rows;
    for (uint32_t y = 0; y < 4; ++y)
        for (uint32_t x = 0; x < 4; ++x) rows += texels.At(x, y)[0] == 8.0f ? 'F' : '.';
    EXPECT_EQ(rows, "FFFFFF..FF......");
    // Linear between the centers of coarse pixels
    const Texels scaled = harness.Run([&](PassHarness& h) {
        return passes::Upscale(
            h.Graph(), h.Texture("coarse", {2, 1}, Format::Rgba32Float, {0, 0, 0, 1, 8, 0, 0, 1}), {8, 3});
    });
    const float expected[8] = {0, 0, 1, 3, 5, 7, 8, 8};
    for (uint32_t x = 0; x < 8; ++x) EXPECT_NEAR(scaled.At(x, 2)[0], expected[x], 1e-5f);
}

TEST_F(Compare, Viewport_GivesTheNumbersOfWhatItShows) {
    ViewedScene viewed(Device());
    EXPECT_FALSE(viewed.viewport.Numbers().has_value());
    double means[3] = {};
    int i = 0;
    for (const View view : {View::Difference, View::RelativeError, View::Flip}) {
        viewed.viewport.SetView(view);
        viewed.RenderFrames(2);
        Device().WaitIdle();
        const std::optional<viewport::CompareNumbers> numbers = viewed.viewport.Numbers();
        ASSERT_TRUE(numbers.has_value());
        EXPECT_EQ(numbers->view, view);
        EXPECT_EQ(numbers->pathTracedSamples, viewed.Samples());
        EXPECT_EQ(numbers->otherVersion, viewed.viewport.Progress().rasterSamples);
        EXPECT_GE(numbers->numbers.maximum, numbers->numbers.mean);
        means[i++] = numbers->numbers.mean;
    }
    // Without what is scattered more than once, the raster view is darker, but it is not black
    EXPECT_GT(means[1], 0.02);
    EXPECT_LT(means[1], 1.0);
    EXPECT_GT(means[2], 0.01);
    EXPECT_LT(means[2], 0.95);
}

TEST_F(Compare, Viewport_MakesAMapAnewOnlyWhenItsPicturesChange) {
    ViewedScene viewed(Device());
    viewed.viewport.SetBudget({.maxSamples = 2, .maxRasterSamples = 2});
    viewed.viewport.SetView(View::Flip);
    const auto isMade = [&] {
        viewed.RenderFrames(1);
        return viewed.renderer.DescribePlan().find("FlipColumns") != std::string::npos;
    };
    EXPECT_TRUE(isMade());
    EXPECT_TRUE(isMade());
    EXPECT_FALSE(isMade());
    viewport::ShowSettings show = viewed.viewport.Show();
    show.tonemap.exposureEv = 1.0f;
    viewed.viewport.SetShow(show);
    EXPECT_TRUE(isMade());
    EXPECT_FALSE(isMade());
    // The map is made anew for other pictures with the same number of samples
    viewed.viewport.SetBudget({.maxSamples = 1, .maxRasterSamples = 1, .settleMs = 0.0});
    for (const float x : {0.1f, 0.2f}) {
        scene::CameraView camera = InsideBoxes();
        camera.eye.x += x;
        viewed.viewport.SetCamera(camera);
        EXPECT_TRUE(isMade());
        isMade();  // how fine the new picture is becomes known in the next frame
        EXPECT_FALSE(isMade());
    }
}

}  // namespace raygraph::testing::compare_test

// Flip against the values in its paper, and against a direct two-dimensional version in double precision.
namespace raygraph::testing::flip_test {

namespace {

using glm::dvec2;
using glm::dvec3;

struct Picture {
    int width, height;
    std::vector<glm::u8vec4> texels;
    const glm::u8vec4& At(int x, int y) const {
        return texels[size_t(std::clamp(y, 0, height - 1) * width + std::clamp(x, 0, width - 1))];
    }
};

Picture MakePicture(int width, int height, const std::function<glm::ivec3(int x, int y)>& color) {
    Picture picture{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) picture.texels.emplace_back(color(x, y), 255);
    return picture;
}

Picture Plain(int width, int height, glm::ivec3 color) {
    return MakePicture(width, height, [&](int, int) { return color; });
}

// --- FLIP as the paper writes it: filters in two dimensions, nothing separated, in double ---

constexpr double kPi = std::numbers::pi;
const dvec3 kWhite(23359437.0 / 24577794.0, 1.0, 80288307.0 / 73733382.0);

// sRGB primaries by their chromaticities and a white of D65.
dvec3 ToXyz(dvec3 c) {
    return {10135552.0 / 24577794.0 * c.x + 8788810.0 / 24577794.0 * c.y + 4435075.0 / 24577794.0 * c.z,
            2613072.0 / 12288897.0 * c.x + 8788810.0 / 12288897.0 * c.y + 887015.0 / 12288897.0 * c.z,
            1425312.0 / 73733382.0 * c.x + 8788810.0 / 73733382.0 * c.y + 70074185.0 / 73733382.0 * c.z};
}

dvec3 FromXyz(dvec3 xyz) {
    const glm::dmat3 toXyz(ToXyz({1, 0, 0}), ToXyz({0, 1, 0}), ToXyz({0, 0, 1}));
    return glm::inverse(toXyz) * xyz;
}

dvec3 Linear(const glm::u8vec4& texel) {
    const auto decode = [](double v) {
        return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    };
    return {decode(texel.x / 255.0), decode(texel.y / 255.0), decode(texel.z / 255.0)};
}

dvec3 YCxCz(dvec3 linear) {
    const dvec3 v = ToXyz(linear) / kWhite;
    return {116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z)};
}

dvec3 HuntLab(dvec3 linear) {
    const auto f = [](double t) {
        const double d = 6.0 / 29.0;
        return t > d * d * d ? std::cbrt(t) : t / (3.0 * d * d) + 4.0 / 29.0;
    };
    const dvec3 v = ToXyz(linear) / kWhite;
    const double l = 116.0 * f(v.y) - 16.0;
    return {l, 0.01 * l * 500.0 * (f(v.x) - f(v.y)), 0.01 * l * 200.0 * (f(v.y) - f(v.z))};
}

double HyAb(dvec3 a, dvec3 b) {
    return std::abs(a.x - b.x) + glm::length(dvec2(a.y - b.y, a.z - b.z));
}

dvec3 Filtered(const Picture& picture, int x, int y, double ppd) {
    const auto weight = [&](int channel, double d2) {
        const double a[3][2] = {{1.0, 0.0}, {1.0, 0.0}, {34.1, 13.5}};
        const double b[3][2] = {{0.0047, 1e-5}, {0.0053, 1e-5}, {0.04, 0.025}};
        double sum = 0.0;
        for (int i = 0; i < 2; ++i)
            sum += a[channel][i] * std::sqrt(kPi / b[channel][i]) * std::exp(-kPi * kPi * d2 / b[channel][i]);
        return sum;
    };
    const int radius = int(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * kPi * kPi)) * ppd));
    dvec3 sum(0.0), weights(0.0);
    for (int j = -radius; j <= radius; ++j)
        for (int i = -radius; i <= radius; ++i) {
            const dvec3 c = YCxCz(Linear(picture.At(x + i, y + j)));
            for (int channel = 0; channel < 3; ++channel) {
                const double w = weight(channel, double(i * i + j * j) / (ppd * ppd));
                sum[channel] += w * c[channel];
                weights[channel] += w;
            }
        }
    const dvec3 c = sum / weights;
    const double v = (c.x + 16.0) / 116.0;
    const dvec3 xyz = dvec3(v + c.y / 500.0, v, v - c.z / 200.0) * kWhite;
    return HuntLab(glm::clamp(FromXyz(xyz), dvec3(0.0), dvec3(1.0)));
}

// Lengths of the responses to edges and to points.
dvec2 Features(const Picture& picture, int x, int y, double ppd) {
    const double sd = 0.5 * 0.082 * ppd;
    const int radius = int(std::ceil(3.0 * sd));
    const auto kernel = [&](bool isPoint, int i, int j) {
        const double g = std::exp(-double(i * i + j * j) / (2.0 * sd * sd));
        return isPoint ? (double(i * i) / (sd * sd) - 1.0) * g : -double(i) * g;
    };
    dvec2 result;
    for (int isPoint = 0; isPoint < 2; ++isPoint) {
        double positive = 0.0, negative = 0.0;
        for (int j = -radius; j <= radius; ++j)
            for (int i = -radius; i <= radius; ++i) {
                const double k = kernel(isPoint == 1, i, j);
                (k > 0.0 ? positive : negative) += std::abs(k);
            }
        dvec2 response(0.0);
        for (int j = -radius; j <= radius; ++j)
            for (int i = -radius; i <= radius; ++i) {
                const double v = (YCxCz(Linear(picture.At(x + i, y + j))).x + 16.0) / 116.0;
                const double along = kernel(isPoint == 1, i, j), across = kernel(isPoint == 1, j, i);
                response.x += v * along / (along > 0.0 ? positive : negative);
                response.y += v * across / (across > 0.0 ? positive : negative);
            }
        result[isPoint] = glm::length(response);
    }
    return result;
}

double ReferenceFlip(const Picture& reference, const Picture& test, int x, int y, double ppd) {
    const double most = std::pow(HyAb(HuntLab({0, 1, 0}), HuntLab({0, 0, 1})), 0.7);
    double color = std::pow(HyAb(Filtered(reference, x, y, ppd), Filtered(test, x, y, ppd)), 0.7);
    color =
        color < 0.4 * most ? 0.95 / (0.4 * most) * color : 0.95 + (color - 0.4 * most) / (0.6 * most) * 0.05;
    const dvec2 apart = glm::abs(Features(reference, x, y, ppd) - Features(test, x, y, ppd));
    const double feature = std::sqrt(std::max(apart.x, apart.y) / std::sqrt(2.0));
    return std::pow(color, 1.0 - feature);
}

class FlipTest : public VulkanTest {
  protected:
    Texels Run(const Picture& reference, const Picture& test, float ppd = 67.0206433f) {
        const auto floats = [](const Picture& picture) {
            std::vector<float> values;
            for (const glm::u8vec4& t : picture.texels)
                for (int i = 0; i < 4; ++i) values.push_back(float(t[i]) / 255.0f);
            return values;
        };
        const Extent2D extent{uint32_t(reference.width), uint32_t(reference.height)};
        return harness.Run([&](PassHarness& h) {
            return passes::Flip(
                h.Graph(), h.Texture("reference", extent, Format::Rgba8Unorm, floats(reference)),
                h.Texture("test", extent, Format::Rgba8Unorm, floats(test)), {.pixelsPerDegree = ppd});
        });
    }
    static double Mean(const Texels& texels) {
        double sum = 0.0;
        for (const float value : texels.values) sum += double{value};
        return sum / double(texels.values.size());
    }

    PassHarness harness{Device()};
};

// Edges, points, colors and gradients.
Picture Scenery(bool isTest) {
    return MakePicture(40, 30, [&](int x, int y) {
        glm::ivec3 c(40 + 4 * x, 30 + 6 * y, 128);
        if (x > 20 && y > (isTest ? 12 : 11)) c = {220, 60, 30};
        if (x == 8 && y == 9) c = isTest ? glm::ivec3(90) : glm::ivec3(255);
        if (isTest && x < 12 && y > 20) c.z = 90;
        return c;
    });
}

}  // namespace

TEST_F(FlipTest, Flip_IsThePlainFormInTwoDimensions) {
    const Picture reference = Scenery(false), test = Scenery(true);
    for (const float ppd : {67.0206433f, 25.0f}) {
        const Texels map = Run(reference, test, ppd);
        for (const glm::ivec2 at :
             {glm::ivec2(8, 9), {0, 0}, {20, 12}, {25, 11}, {39, 29}, {3, 25}, {11, 20}})
            EXPECT_NEAR(map.At(uint32_t(at.x), uint32_t(at.y))[0],
                        ReferenceFlip(reference, test, at.x, at.y, double{ppd}), 2e-3)
                << at.x << ", " << at.y << " at " << ppd;
    }
}

TEST_F(FlipTest, Flip_IsZeroForEqualPictures) {
    const Texels map = Run(Scenery(false), Scenery(false));
    EXPECT_EQ(*std::max_element(map.values.begin(), map.values.end()), 0.0f);
}

TEST_F(FlipTest, Flip_IsSymmetric) {
    EXPECT_EQ(Run(Scenery(false), Scenery(true)).values, Run(Scenery(true), Scenery(false)).values);
}

// HyAB of black and white is 100, and that of green and blue, the greatest m, 203.30: 100^0.7 = 25.119,
// m^0.7 = 41.276, and 0.95 + (25.119 - 0.4 * 41.276) / (0.6 * 41.276) * 0.05 = 0.9674.
TEST_F(FlipTest, Flip_OfBlackAndWhiteIsWhatFollowsByHand) {
    const Texels map = Run(Plain(24, 24, glm::ivec3(0)), Plain(24, 24, glm::ivec3(255)));
    for (const float value : map.values) ASSERT_NEAR(value, 0.9674, 2e-4);
}

TEST_F(FlipTest, Flip_GrowsWithTheDifference) {
    const Picture gray = Plain(16, 16, glm::ivec3(100));
    double last = 0.0;
    for (const int step : {1, 3, 10, 30, 100}) {
        const double mean = Mean(Run(gray, Plain(16, 16, glm::ivec3(100 + step))));
        EXPECT_GT(mean, last);
        last = mean;
    }
}

TEST_F(FlipTest, Flip_OfFineDetailFadesWithTheDistance) {
    const Picture gray = Plain(32, 32, glm::ivec3(128));
    const Picture checks =
        MakePicture(32, 32, [](int x, int y) { return glm::ivec3((x + y) % 2 ? 150 : 106); });
    EXPECT_GT(Mean(Run(gray, checks, 10.0f)), 1.5 * Mean(Run(gray, checks, 100.0f)));
}

TEST_F(FlipTest, Flip_RefusesWhatItCannotCompare) {
    EXPECT_THROW(Run(Plain(4, 4, glm::ivec3(0)), Plain(4, 4, glm::ivec3(0)), 0.5f), Error);
    EXPECT_THROW(harness.Run([&](PassHarness& h) {
        return passes::Flip(h.Graph(), h.Texture("a", {4, 4}, Format::Rgba8Unorm, {0, 0, 0, 1}),
                            h.Texture("b", {4, 5}, Format::Rgba8Unorm, {0, 0, 0, 1}));
    }),
                 Error);
}

}  // namespace raygraph::testing::flip_test

// The outline of the selection: with hand-made texels, and in a viewport.
namespace raygraph::testing::outline_test {

using ::testing::HasSubstr;
using ::testing::Not;

namespace {

class Outline : public VulkanTest {
  protected:
    // Returns the outline of the given instances; `seen` holds instance + 1 of each pixel.
    Texels LineOf(const std::vector<float>& seen, Extent2D from, Extent2D extent,
                  const std::vector<uint32_t>& instances, float width) {
        std::vector<float> hits;
        for (const float instance : seen) hits.insert(hits.end(), {instance, 7, 0, 0});
        return harness.Run([&](PassHarness& h) {
            const TextureId line = h.Graph().CreateTexture("line", {extent, Format::R32Float});
            return passes::OutlineInstances(h.Graph(), h.Texture("hits", from, Format::Rgba32Uint, hits),
                                            instances, line, width);
        });
    }
    PassHarness harness{Device()};
};

std::string Row(const Texels& line, uint32_t y) {
    std::string row;
    for (uint32_t x = 0; x < line.extent.width; ++x) {
        const float share = line.At(x, y)[0];
        row += share == 0.0f ? '.' : share == 1.0f ? '#' : '+';
    }
    return row;
}

class OutlinedViewport : public VulkanTest {
  protected:
    struct Shown {
        std::vector<uint8_t> picture, outlined;
    };
    Shown Frame() {
        viewed.renderer.BeginFrame();
        const TextureId picture = viewed.viewport.Declare();
        if (afterDeclare) afterDeclare();
        const TextureId outlined = viewed.viewport.DeclareOutline(picture);
        const Readback plain = viewed.renderer.ReadBack(picture), over = viewed.renderer.ReadBack(outlined);
        viewed.renderer.Execute();
        over.Wait();
        plain.Wait();
        const auto bytes = [](const Readback& readback) {
            const auto* first = reinterpret_cast<const uint8_t*>(readback.Bytes().data());
            return std::vector<uint8_t>(first, first + readback.Bytes().size());
        };
        return {bytes(plain), bytes(over)};
    }
    static size_t DifferentPixels(const Shown& shown) {
        size_t count = 0;
        for (size_t i = 0; i < shown.picture.size(); i += 4)
            count += !std::equal(&shown.picture[i], &shown.picture[i] + 4, &shown.outlined[i]);
        return count;
    }
    ViewedScene viewed{Device(), {48, 32}};
    std::function<void()> afterDeclare;
};

}  // namespace

TEST_F(Outline, LineLiesAroundTheInstancesAndNotOnThem) {
    const std::vector<float> seen{0, 0, 0,  0,  0, 0, 0,  //
                                  0, 0, 0,  0,  0, 0, 0,  //
                                  0, 0, 34, 34, 5, 0, 0,  //
                                  0, 0, 34, 34, 5, 0, 0,  //
                                  0, 0, 0,  0,  0, 0, 0};
    const Texels one = LineOf(seen, {7, 5}, {7, 5}, {33}, 1.0f);
    EXPECT_EQ(Row(one, 0), ".......");
    EXPECT_EQ(Row(one, 1), ".+##+..") << "corners are farther away: sqrt 2";
    EXPECT_EQ(Row(one, 2), ".#..#..") << "of the other instance's pixels, too";
    EXPECT_EQ(Row(one, 4), ".+##+..");
    EXPECT_NEAR(one.At(1, 1)[0], 2.0f - std::sqrt(2.0f), 1e-5f);
    const Texels both = LineOf(seen, {7, 5}, {7, 5}, {4, 33}, 1.0f);
    EXPECT_EQ(Row(both, 2), ".#...#.") << "nothing between what belongs together";
    const Texels wide = LineOf(seen, {7, 5}, {7, 5}, {33}, 2.0f);
    EXPECT_EQ(Row(wide, 2), "##..##.");
    EXPECT_EQ(Row(LineOf(seen, {7, 5}, {7, 5}, {100}, 1.0f), 2), ".......") << "which nothing shows";
}

TEST_F(Outline, CoarserHitsGiveACoarserLine) {
    const std::vector<float> seen{0, 0, 0, 9, 0, 0};
    const Texels line = LineOf(seen, {3, 2}, {6, 4}, {8}, 1.0f);
    EXPECT_EQ(Row(line, 0), "......");
    EXPECT_EQ(Row(line, 1), "##+...");
    EXPECT_EQ(Row(line, 3), "..#...");
}

TEST_F(Outline, DrawnLineCoversThePictureByItsShare) {
    const Texels drawn = harness.Run([&](PassHarness& h) {
        return passes::DrawOutline(h.Graph(), h.Texture("picture", {3, 1}, Format::Rgba8Unorm, {0, 0, 1, 1}),
                                   h.Texture("line", {3, 1}, Format::R32Float, {0.0f, 0.5f, 1.0f}),
                                   {1, 0, 0});
    });
    EXPECT_EQ(drawn.At(0, 0)[2], 1.0f);
    EXPECT_NEAR(drawn.At(1, 0)[0], 0.5f, 0.01f);
    EXPECT_NEAR(drawn.At(1, 0)[2], 0.5f, 0.01f);
    EXPECT_EQ(drawn.At(2, 0)[0], 1.0f);
    EXPECT_EQ(drawn.At(2, 0)[2], 0.0f);
    EXPECT_EQ(drawn.At(2, 0)[3], 1.0f);
}

TEST_F(Outline, RefusesWhatItCannotDraw) {
    EXPECT_THROW(LineOf({1}, {1, 1}, {2, 2}, {0}, 0.0f), Error);
    EXPECT_THROW(LineOf({1}, {1, 1}, {2, 2}, {0}, 9.0f), Error);
}

TEST_F(OutlinedViewport, SelectionIsOutlinedAndAccumulationGoesOn) {
    viewed.RenderFrames(2);
    const uint32_t samples = viewed.Samples(), resets = viewed.AllResets();
    EXPECT_EQ(DifferentPixels(Frame()), 0u) << "nothing is selected";
    EXPECT_THAT(viewed.renderer.DescribePlan(), Not(HasSubstr("Outline")));
    viewed.viewport.SetOutlined({1});
    const size_t line = DifferentPixels(Frame());
    EXPECT_GT(line, 30u);
    EXPECT_LT(line, 500u);
    EXPECT_THAT(viewed.renderer.DescribePlan(), HasSubstr("OutlineInstances"));
    EXPECT_EQ(DifferentPixels(Frame()), line);
    EXPECT_THAT(viewed.renderer.DescribePlan(), Not(HasSubstr("OutlineInstances"))) << "it is kept";
    EXPECT_EQ(viewed.Samples(), samples + 3);
    EXPECT_EQ(viewed.AllResets(), resets);
    viewed.viewport.SetOutlined({});
    EXPECT_EQ(DifferentPixels(Frame()), 0u);
}

TEST_F(OutlinedViewport, LineFollowsCameraTransformAndSize) {
    viewed.viewport.SetOutlined({1});
    const Shown before = Frame();
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.2f;
    viewed.viewport.SetCamera(camera);
    Frame();
    EXPECT_THAT(viewed.renderer.DescribePlan(), HasSubstr("OutlineInstances"));
    viewed.scene.SetTransform(1, Translation({0.2f, -0.4f, 0.1f}));
    Frame();
    EXPECT_THAT(viewed.renderer.DescribePlan(), HasSubstr("OutlineInstances"));
    viewed.viewport.SetSize({20, 30});
    EXPECT_EQ(Frame().outlined.size(), size_t{20} * 30 * 4);
    viewed.viewport.SetView(View::SideBySide);
    EXPECT_EQ(DifferentPixels(Frame()), 0u);
}

// The line is drawn again after every change of the scene that may move it, and after no other.
TEST_F(OutlinedViewport, LineFollowsEveryChangeOfTheSceneThatMayMoveIt) {
    scene::SceneData data = Boxes();
    scene::Mesh& inner = data.meshes[1];
    inner.weights = {0.0f};
    scene::MorphTarget& target = inner.primitives[0].targets.emplace_back();
    for (const glm::vec3& position : inner.primitives[0].positions)
        target.positions.push_back({0.5f * position.y, 0, 0});
    scene::UpdateDeformationBounds(inner.primitives[0]);
    data.instances[1].isDeformed = true;
    scene::Material veil = data.materials[1];
    veil.alphaMode = scene::AlphaMode::Blend;
    veil.baseColorFactor.a = 0.75f;
    data.materials[1] = veil;
    viewed.scene.SetScene(std::move(data));
    viewed.viewport.SetOutlined({1});
    veil.baseColorFactor.a = 0.5f;
    scene::Light light = viewed.scene.Light(0);
    light.intensity *= 2.0f;
    struct Edit {
        const char* name;
        bool moves;
        std::function<void(GpuScene&)> apply;
    };
    const Edit edits[] = {
        {"shape", true, [](GpuScene& scene) { scene.SetMorphWeights(1, std::array{1.0f}); }},
        {"transform", true,
         [](GpuScene& scene) {
             scene.SetTransform(1, Translation({0.2f, -0.4f, 0}));
         }},
        {"light", false, [&](GpuScene& scene) { scene.SetLight(0, light); }},
        {"environment", false, [](GpuScene& scene) { scene.SetEnvironment({.radiance = glm::vec3(1.0f)}); }},
        {"visibility", true, [](GpuScene& scene) { scene.SetVisible(0, false); }},
        {"alpha", true, [&](GpuScene& scene) { scene.SetMaterial(1, veil); }},
    };
    auto rows = OptionRowsOf<SceneRevisions>([](SceneRevisions& s) {
        auto& [geometry, transforms, shapes, materials, lights, environment] = s;
        return std::tie(geometry, transforms, shapes, materials, lights, environment);
    });
    const auto isDrawn = [&] {
        Frame();
        return viewed.renderer.DescribePlan().find("OutlineInstances") != std::string::npos;
    };
    Frame();
    for (const Edit& edit : edits) {
        SCOPED_TRACE(edit.name);
        const SceneRevisions before = viewed.scene.Revisions();
        edit.apply(viewed.scene);
        rows.Add(edit.name, before, viewed.scene.Revisions());
        EXPECT_EQ(isDrawn(), edit.moves);
        EXPECT_FALSE(isDrawn());
    }
    rows.ExpectComplete();
    viewed.viewport.SetOutlined({0});
    EXPECT_TRUE(isDrawn()) << "of another instance";
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.2f;
    viewed.viewport.SetCamera(camera);
    viewed.viewport.SetBudget({.frameMs = 1e6, .settleMs = 1e9});
    EXPECT_TRUE(isDrawn()) << "coarse, while the camera moves";
    EXPECT_FALSE(isDrawn());
    viewed.viewport.SetBudget({.frameMs = 1e6, .settleMs = 0.0});
    EXPECT_TRUE(isDrawn()) << "as fine as it is when nothing moves";
    EXPECT_FALSE(isDrawn());
}

TEST_F(OutlinedViewport, CameraSetAfterDeclareIsOfTheNextFramesLine) {
    viewed.viewport.SetOutlined({1});
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.2f;
    afterDeclare = [&] { viewed.viewport.SetCamera(camera); };
    Frame();  // the line of where the camera was
    afterDeclare = {};
    Frame();
    EXPECT_THAT(viewed.renderer.DescribePlan(), HasSubstr("OutlineInstances"));
}

}  // namespace raygraph::testing::outline_test
