// Flip against the values in its paper, and against a direct two-dimensional version in double precision.
#include "passes/compare.h"

#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <numbers>

#include "base/error.h"
#include "renderer/graph/pass_harness.h"
#include "tests/support/vulkan_test.h"

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
