// Tests the denoiser: each of its steps against closed forms or the same computation in double precision, and
// what all of them together promise.
#include "passes/denoise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "passes/denoise_network.h"
#include "renderer/graph/pass_harness.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::denoise_test {

using passes::DenoiseFeatures;
using passes::DenoiseInputs;
using passes::DenoiseSettings;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

using Picture = std::vector<float>;  // RGBA

Picture Filled(Extent2D extent, std::array<float, 4> value) {
    Picture picture;
    for (uint32_t i = 0; i < extent.width * extent.height; ++i)
        picture.insert(picture.end(), value.begin(), value.end());
    return picture;
}

template <typename Function>  // from x, y to a gray
Picture Gray(Extent2D extent, const Function& function) {
    Picture picture;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            const float value = function(x, y);
            picture.insert(picture.end(), {value, value, value, 1.0f});
        }
    return picture;
}

Picture Random(Extent2D extent, uint32_t seed, float least, float most) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<float> uniform(least, most);
    Picture picture(size_t{4} * extent.width * extent.height);
    for (float& value : picture) value = uniform(generator);
    return picture;
}

struct Render {
    Picture mean, variance, albedo, normal, firstHalf;
};

// A render whose samples are normally distributed: the picture that is given plus noise.
Render Noisy(Extent2D extent, const Picture& truth, float deviation, uint32_t samples) {
    std::mt19937 generator(7);
    std::normal_distribution<float> normal(0.0f, deviation / std::sqrt(static_cast<float>(samples) / 2.0f));
    Render render{truth,
                  Filled(extent, {deviation * deviation, deviation * deviation, deviation * deviation, 0}),
                  Filled(extent, {0.5f, 0.5f, 0.5f, 1}), Filled(extent, {0, 0, 1, 0}), truth};
    for (size_t i = 0; i < truth.size(); ++i) {
        if (i % 4 == 3) continue;
        const float first = normal(generator), second = normal(generator);
        render.firstHalf[i] += first;
        render.mean[i] += 0.5f * (first + second);
    }
    return render;
}

double SquaredError(const Picture& a, const Picture& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
    return sum;
}

class Denoising : public VulkanTest {
  protected:
    TextureId Texture(const char* name, Extent2D extent, const Picture& picture) {
        return harness.Texture(name, extent, Format::Rgba32Float, picture);
    }
    DenoiseInputs Inputs(Extent2D extent, const Render& render) {
        DenoiseInputs inputs{.mean = Texture("mean", extent, render.mean),
                             .variance = Texture("variance", extent, render.variance),
                             .albedo = Texture("albedo", extent, render.albedo),
                             .normal = Texture("normal", extent, render.normal),
                             .firstHalf = {},
                             .seen = {}};
        if (!render.firstHalf.empty()) inputs.firstHalf = Texture("firstHalf", extent, render.firstHalf);
        return inputs;
    }
    Picture Denoise(Extent2D extent, const Render& render, uint32_t samples) {
        const uint32_t first = render.firstHalf.empty() ? 0 : samples / 2;
        return harness
            .Run([&](PassHarness& h) {
                return passes::Denoise(h.Graph(), Inputs(extent, render), {samples, first, denoiser});
            })
            .values;
    }
    Picture Noise(Extent2D extent, const Render& render, const DenoiseSettings& settings) {
        return harness
            .Run([&](PassHarness& h) {
                const DenoiseInputs inputs = Inputs(extent, render);
                return passes::NoiseOfMean(h.Graph(), inputs, passes::FeaturesOf(h.Graph(), inputs),
                                           settings);
            })
            .values;
    }
    PassHarness harness{Device()};
    passes::Denoiser denoiser = passes::Denoiser::Network;
};

// EachDenoiser runs what every denoiser promises.
class EachDenoiser : public Denoising, public ::testing::WithParamInterface<passes::Denoiser> {
  protected:
    EachDenoiser() { denoiser = GetParam(); }
};
INSTANTIATE_TEST_SUITE_P(, EachDenoiser, ::testing::ValuesIn(Values<passes::Denoiser>()),
                         [](const auto& tested) { return Name(tested.param); });

float SquaredGradient(const Picture& picture, Extent2D extent, uint32_t x, uint32_t y) {
    const auto at = [&](int64_t i, int64_t j, int c) {
        i = std::clamp<int64_t>(i, 0, extent.width - 1);
        j = std::clamp<int64_t>(j, 0, extent.height - 1);
        return picture[4 * (j * extent.width + i) + c];
    };
    float sum = 0.0f;
    for (int c = 0; c < 3; ++c) {
        const float center = at(x, y, c);
        const float dx =
            std::min(std::abs(at(x + 1, y, c) - center), std::abs(center - at(int64_t{x} - 1, y, c)));
        const float dy =
            std::min(std::abs(at(x, y + 1, c) - center), std::abs(center - at(x, int64_t{y} - 1, c)));
        sum += dx * dx + dy * dy;
    }
    return 4.0f * sum;
}

// Pilot and Candidates in double precision.
struct Regression {
    Extent2D extent;
    Picture target, guide, albedo, normal;
    int patchRadius;
    double scale;      // of the variances in the guide
    Picture variance;  // in w; the weight of a pixel with more than `trusted` times that of another falls
    double trusted;

    double Distance(int px, int py, int qx, int qy) const {
        const int width = int(extent.width), height = int(extent.height), r = patchRadius;
        const auto at = [&](int x, int y) {
            return size_t(std::clamp(y, 0, height - 1)) * width + std::clamp(x, 0, width - 1);
        };
        const size_t p = at(px, py), q = at(qx, qy);
        const auto squared = [&](const Picture& feature, size_t i, size_t j) {
            double sum = 0.0;
            for (int c = 0; c < 3; ++c) sum += std::pow(double(feature[4 * i + c]) - feature[4 * j + c], 2);
            return sum;
        };
        const auto least = [&](const Picture& feature) {
            return std::min(SquaredGradient(feature, extent, px, py),
                            SquaredGradient(feature, extent, qx, qy));
        };
        double sum = 0.0;
        for (int dy = -r; dy <= r; ++dy)
            for (int dx = -r; dx <= r; ++dx) {
                const size_t u = at(px + dx, py + dy), w = at(qx + dx, qy + dy);
                const double vu = guide[4 * u + 3], vw = guide[4 * w + 3];
                sum += (squared(guide, u, w) / (3.0 * scale) - vu - std::min(vu, vw)) / (vu + vw);
            }
        return std::max(sum / ((2 * r + 1) * (2 * r + 1)), 0.0) +
               0.1 * (squared(albedo, p, q) / (0.0016 + least(albedo)) +
                      squared(normal, p, q) / (0.04 + least(normal)));
    }
    std::array<double, 4> At(int px, int py) const {
        constexpr int kTerms = 9, kRadius = 6;
        double moments[kTerms][kTerms] = {}, products[kTerms][3] = {};
        const size_t p = size_t(py) * extent.width + px;
        for (int y = std::max(py - kRadius, 0); y <= std::min(py + kRadius, int(extent.height) - 1); ++y)
            for (int x = std::max(px - kRadius, 0); x <= std::min(px + kRadius, int(extent.width) - 1); ++x) {
                const double distance = Distance(px, py, x, y);
                if (distance >= 12.0) continue;
                const size_t q = size_t(y) * extent.width + x;
                const double weight =
                    std::min(trusted * variance[4 * p + 3] / variance[4 * q + 3], 1.0) * std::exp(-distance);
                double terms[kTerms] = {1.0};
                for (int c = 0; c < 3; ++c) terms[1 + c] = double(albedo[4 * q + c]) - albedo[4 * p + c];
                for (int c = 0; c < 3; ++c) terms[4 + c] = double(normal[4 * q + c]) - normal[4 * p + c];
                terms[7] = double(x - px) / kRadius;
                terms[8] = double(y - py) / kRadius;
                for (int i = 0; i < kTerms; ++i) {
                    for (int j = 0; j < kTerms; ++j) moments[i][j] += weight * terms[i] * terms[j];
                    for (int c = 0; c < 3; ++c) products[i][c] += weight * terms[i] * target[4 * q + c];
                }
            }
        for (int i = 1; i < kTerms; ++i) moments[i][i] += 0.1 * moments[i][i] + 0.001 * moments[0][0] + 1e-6;
        // Gauss and Jordan's elimination gives the first row of the inverse
        double solution[kTerms] = {1.0};
        for (int k = 0; k < kTerms; ++k)
            for (int i = 0; i < kTerms; ++i) {
                if (i == k) continue;
                const double factor = moments[i][k] / moments[k][k];
                for (int j = 0; j < kTerms; ++j) moments[i][j] -= factor * moments[k][j];
                solution[i] -= factor * solution[k];
            }
        std::array<double, 4> result{};
        for (int i = 0; i < kTerms; ++i)
            for (int c = 0; c < 3; ++c) result[c] += solution[i] / moments[i][i] * products[i][c];
        for (int c = 0; c < 3; ++c) result[c] = std::max(result[c], 0.0);
        result[3] = solution[0] / moments[0][0];
        return result;
    }
};

}  // namespace

TEST_F(Denoising, FeaturesHaveTheSmallerOneSidedGradient) {
    const Extent2D extent{5, 4};
    Picture albedo = Random(extent, 1, 0.0f, 1.0f), normal = Random(extent, 2, -1.0f, 1.0f);
    for (const bool isNormal : {false, true}) {
        const Texels out = harness.Run([&](PassHarness& h) {
            const DenoiseFeatures features =
                passes::FeaturesOf(h.Graph(), Inputs(extent, {normal, normal, albedo, normal, {}}));
            return isNormal ? features.normal : features.albedo;
        });
        const Picture& in = isNormal ? normal : albedo;
        for (uint32_t y = 0; y < extent.height; ++y)
            for (uint32_t x = 0; x < extent.width; ++x) {
                for (int c = 0; c < 3; ++c) EXPECT_EQ(out.At(x, y)[c], in[4 * (y * extent.width + x) + c]);
                EXPECT_NEAR(out.At(x, y)[3], SquaredGradient(in, extent, x, y), 1e-5f);
            }
    }
}

TEST_F(Denoising, NoiseOfIndependentSamplesIsTheirVarianceOverTheirCount) {
    const Extent2D extent{4, 1};
    Render render = Noisy(extent, Filled(extent, {1, 1, 1, 1}), 0.0f, 2);
    render.firstHalf.clear();
    render.variance = {8, 4, 2, 9, kNan, kInfinity, -1, 9, 0, 0, 0, 0, 16, 0, 1, 0};
    const Picture noise = Noise(extent, render, {.samples = 8});
    const float expected[] = {1, 0.5f, 0.25f, 0, 0, 0, 0, 0, 0, 2, 0, 0.125f};
    for (int i = 0; i < 12; ++i) EXPECT_FLOAT_EQ(noise[4 * (i / 3) + i % 3], expected[i]) << i;
}

TEST_F(Denoising, NoiseIsScaledByTheDifferenceOfBothHalves) {
    const Extent2D extent{20, 17};
    Render render = Noisy(extent, Filled(extent, {2, 2, 2, 1}), 0.0f, 2);
    render.variance = Filled(extent, {0.64f, 0.64f, 0.64f, 0});
    render.firstHalf = Filled(extent, {2.05f, 2.05f, 2.05f, 1});
    // 64 samples, the first 48: of the mean the noise by halves is 0.05^2 48 / 16 / 1.17
    const double ratio = 0.0025 * 3.0 / 1.17 / 0.01, rate = -std::log(ratio) / std::log(16.0);
    for (const float value : {Noise(extent, render, {64, 48})[0], Noise(extent, render, {64, 48}).end()[-2]})
        EXPECT_NEAR(value, 0.01 * ratio * std::pow(2.0, -rate), 1e-6);
    // Where halves differ more than independent ones would, the variance of the samples is trusted
    render.firstHalf = Filled(extent, {3, 3, 3, 1});
    EXPECT_FLOAT_EQ(Noise(extent, render, {64, 48})[0], 0.01f);
    render.firstHalf = render.mean;
    EXPECT_EQ(Noise(extent, render, {64, 48})[0], 0.0f);
}

// In the left part, each of eight samples sees a light or finds other radiance with noise. Its halves, which
// agree, must not tell how noisy the right part is.
TEST_F(Denoising, NoiseIsThatOfWhatIsNotSeenDirectly) {
    const Extent2D extent{40, 1};
    constexpr uint32_t kSamples = 8, kLit = 20;
    std::mt19937 generator(5);
    std::normal_distribution<double> noise(1.0, 0.3);
    Render render = Noisy(extent, Filled(extent, {1, 1, 1, 1}), 0.0f, 2);
    Picture seen = Filled(extent, {}), squares = seen, expected = seen;
    for (uint32_t x = 0; x < extent.width; ++x) {
        double mean = 0.0, square = 0.0, meanOfRest = 0.0, squareOfRest = 0.0, light = 0.0;
        for (uint32_t i = 0; i < kSamples; ++i) {
            const bool isLit = x < kLit && generator() % 2 == 0;
            const double value = isLit ? 20.0 : noise(generator), rest = isLit ? 0.0 : value;
            mean += value / kSamples;
            square += value * value / kSamples;
            meanOfRest += rest / kSamples;
            squareOfRest += rest * rest / kSamples;
            light += isLit ? value / kSamples : 0.0;
        }
        const double unbiased = double{kSamples} / (kSamples - 1);
        for (size_t c = 4 * size_t{x}; c < 4 * size_t{x} + 3; ++c) {
            render.mean[c] = static_cast<float>(mean);
            render.firstHalf[c] = render.mean[c] + (x < kLit ? 0.0f : 0.02f);
            render.variance[c] = static_cast<float>(unbiased * (square - mean * mean));
            seen[c] = static_cast<float>(light);
            squares[c] = 20.0f * seen[c];
            expected[c] = static_cast<float>(unbiased * (squareOfRest - meanOfRest * meanOfRest)) / kSamples;
        }
    }
    const auto noiseOf = [&](uint32_t firstSamples) {
        return harness
            .Run([&](PassHarness& h) {
                DenoiseInputs inputs = Inputs(extent, render);
                if (firstSamples == 0) inputs.firstHalf = {};
                const TextureId bySamples = Texture("seen", extent, seen);
                inputs.seen = {bySamples, bySamples, Texture("seenSquares", extent, squares)};
                return passes::NoiseOfMean(h.Graph(), inputs, passes::FeaturesOf(h.Graph(), inputs),
                                           {kSamples, firstSamples});
            })
            .values;
    };
    const Picture independent = noiseOf(0);
    for (size_t i = 0; i < expected.size(); i += 4) EXPECT_NEAR(independent[i], expected[i], 5e-4f) << i;
    const Picture scaled = noiseOf(4);
    const auto ratioAt = [&](uint32_t x) { return scaled[4 * size_t{x}] / independent[4 * size_t{x}]; };
    const float alone = ratioAt(kLit + 8);
    EXPECT_GT(alone, 0.0f);
    EXPECT_LT(alone, 0.5f);
    EXPECT_GT(ratioAt(kLit), 0.2f * alone);
}

TEST_F(Denoising, NoiseOfASingleSampleIsTheVarianceOfItsNeighborsOnTheSameSurface) {
    const Extent2D extent{16, 9};
    Render render = Noisy(
        extent, Gray(extent, [](uint32_t x, uint32_t y) { return (x + y) % 2 ? 3.0f : 1.0f; }), 0.0f, 2);
    render.firstHalf.clear();
    render.albedo = Gray(extent, [](uint32_t x, uint32_t) { return x < 8 ? 0.1f : 0.9f; });
    render.mean[4 * (4 * 16 + 8)] = 1000.0f;  // on another surface
    const Picture noise = Noise(extent, render, {.samples = 1});
    // 7 x 7 neighbors, 25 of one kind; at the edge 28, 14 of each kind
    EXPECT_NEAR(noise[4 * (4 * 16 + 4) + 1], 4.0 * 25.0 * 24.0 / (49.0 * 49.0), 1e-5);
    EXPECT_NEAR(noise[4 * (4 * 16 + 7)], 1.0, 1e-4);
}

TEST_F(Denoising, RegressionsAreThoseInDoublePrecision) {
    const Extent2D extent{21, 19};
    const Picture target = Random(extent, 1, 0.0f, 2.0f), albedo = Random(extent, 4, 0.4f, 0.5f),
                  normal = Random(extent, 5, -0.1f, 0.1f), guide = Random(extent, 2, 0.1f, 1.0f);
    Picture noisy = target;
    for (size_t i = 3; i < noisy.size(); i += 4) noisy[i] = std::exp(4.0f * (noisy[i] - 1.0f));
    const double scales[] = {1.0, 0.7 * 0.7, 1.4 * 1.4, 2.8 * 2.8};
    for (size_t which = 0; which < 4; ++which) {  // the pilot, then candidates
        const bool isPilot = which == 0;
        const Regression expected{
            extent, isPilot ? guide : target, guide, albedo, normal, isPilot ? 1 : 0, scales[which],
            noisy,  isPilot ? 1e9 : 8.0};
        const Texels out = harness.Run([&](PassHarness& h) {
            const TextureId mean = Texture("mean", extent, target), guides = Texture("guide", extent, guide);
            const DenoiseFeatures features =
                passes::FeaturesOf(h.Graph(), Inputs(extent, {target, target, albedo, normal, {}}));
            return isPilot ? passes::Pilot(h.Graph(), guides, features)
                           : passes::Candidates(h.Graph(), mean, Texture("noisy", extent, noisy), guides,
                                                features, 128)[which - 1];
        });
        for (const auto& [x, y] : {std::pair{0, 0}, {10, 9}, {20, 18}, {3, 17}, {20, 0}}) {
            std::array<double, 4> at = expected.At(x, y);
            if (isPilot) {
                double squares = 0.0;
                for (int c = 0; c < 3; ++c) squares += at[c] * at[c];
                at[3] = std::max(at[3], 0.02) * guide[4 * (y * 21 + x) + 3] + 1e-5 * squares / 3.0 + 1e-7;
            }
            for (int c = 0; c < 4; ++c)
                EXPECT_NEAR(out.At(x, y)[c], at[c], 2e-4 * (1.0 + at[c]))
                    << which << ": " << x << " " << y << " " << c;
        }
    }
}

TEST_F(Denoising, FireflyDoesNotSpreadOverNeighborsThatHaveLittleNoise) {
    const Extent2D extent{15, 15};
    Render render = Noisy(extent, Filled(extent, {1, 1, 1, 1}), 0.1f, 64);
    const size_t center = 4 * (7 * 15 + 7);
    for (size_t c = center; c < center + 3; ++c) {
        render.mean[c] = 50.0f;
        render.variance[c] = 64.0f * 49.0f * 49.0f;
        render.firstHalf[c] = 99.0f;
    }
    const Picture out = Denoise(extent, render, 64);
    for (const size_t i : {center - 4 * 3, center + 4 * 3, center + 4 * 3 * 15})
        EXPECT_NEAR(out[i], 1.0f, 0.05f);
}

TEST_F(Denoising, EstimateWithTheSmallestErrorIsBlendedByWhatNoiseExplains) {
    const Extent2D extent{23, 21};
    const auto blend = [&](std::array<float, 3> values, float variance, uint32_t samples) {
        return harness
            .Run([&](PassHarness& h) {
                const auto filled = [&](const char* name, float value, float w) {
                    return Texture(name, extent, Filled(extent, {value, value, value, w}));
                };
                // The mean is 0.5 beside 2
                const Picture mean =
                    Gray(extent, [](uint32_t x, uint32_t y) { return (x + y) % 2 ? 2.5f : 1.5f; });
                const passes::DenoiseCandidates candidates{filled("detailed", values[0], 0.25f),
                                                           filled("medium", values[1], 0.25f),
                                                           filled("smoothed", values[2], 0.25f)};
                const DenoiseInputs inputs = Inputs(extent, {mean, mean, mean, mean, {}});
                const TextureId noise = filled("noise", variance, 0.0f);
                return passes::BlendByError(h.Graph(), inputs, noise,
                                            passes::MixByError(h.Graph(), inputs.mean, noise, candidates),
                                            samples);
            })
            .values;
    };
    // Squared differences are 0.25, of which the noise that was removed explains 1.6 times 0.1 (1 - 0.25)
    const double kept = 1.0 - 1.6 * 0.075 / 0.25;
    for (const std::array<float, 3>& values :
         {std::array{2.0f, 9.0f, 9.0f}, {9.0f, 2.0f, 9.0f}, {9.0f, 9.0f, 2.0f}, {2.0f, 2.0f, 2.0f}}) {
        const Picture out = blend(values, 0.1f, 64);
        EXPECT_NEAR(out[0], 2.0 - 0.5 * kept, 1e-5);
        EXPECT_NEAR(out[4 * (10 * 23 + 11)], 2.0 + 0.5 * kept, 1e-5);
        EXPECT_EQ(out[3], 1.0f);
    }
    // With many samples, less
    EXPECT_NEAR(blend({2.0f, 9.0f, 9.0f}, 0.1f, 25600)[0], 2.0 - 0.5 * (1.0 - 1.006 * 0.3), 1e-5);
    EXPECT_EQ(blend({2.0f, 9.0f, 9.0f}, 0.3f, 64)[0], 2.0f);
    EXPECT_EQ(blend({2.0f, 9.0f, 9.0f}, 0.0f, 64)[0], 1.5f);
    EXPECT_EQ(blend({2.0f, 9.0f, 9.0f}, 0.0f, 1)[0], 2.0f);
}

// A light that covers a part of each pixel in the samples of the picture, and a half in further ones.
TEST_F(Denoising, NoiseOfWhatIsSeenIsThatOfFurtherSamples) {
    const Extent2D extent{24, 24};
    const Picture bySamples = Random(extent, 3, 0.0f, 1000.0f);
    const Picture byAll = Filled(extent, {500, 500, 500, 1});
    Picture truth = byAll;
    for (float& value : truth) value += 1.0f;
    Render render = Noisy(extent, Filled(extent, {1, 1, 1, 1}), 0.1f, 16);
    render.variance = Filled(extent, {1e6f, 1e6f, 1e6f, 0});
    for (Picture Render::*which : {&Render::mean, &Render::firstHalf})
        for (size_t i = 0; i < bySamples.size(); ++i) (render.*which)[i] += bySamples[i];
    const Texels out = harness.Run([&](PassHarness& h) {
        DenoiseInputs inputs = Inputs(extent, render);
        inputs.seen = {Texture("seen", extent, bySamples), Texture("seenByAll", extent, byAll),
                       Texture("seenSquares", extent, Filled(extent, {}))};
        return passes::Denoise(h.Graph(), inputs, {16, 8});
    });
    for (size_t i = 0; i < out.values.size(); ++i) {
        if (i % 4 == 3) continue;
        ASSERT_NEAR(out.values[i], truth[i], 0.1f) << i;
    }
}

TEST_P(EachDenoiser, PictureWithoutNoiseStaysBitForBit) {
    const Extent2D extent{19, 11};
    Render render = Noisy(extent, Random(extent, 3, 0.0f, 5.0f), 0.0f, 2);
    EXPECT_EQ(Denoise(extent, render, 64), render.mean);
}

TEST_P(EachDenoiser, ConstantPictureStays) {
    const Extent2D extent{19, 11};
    Render render = Noisy(extent, Filled(extent, {0.3f, 2.0f, 70.0f, 0.5f}), 0.0f, 2);
    render.variance = Filled(extent, {1, 1, 1, 0});
    for (const uint32_t samples : {64u, 2u, 1u}) {
        if (samples == 1) render.firstHalf.clear();
        const Picture out = Denoise(extent, render, samples);
        for (size_t i = 0; i < out.size(); ++i) EXPECT_NEAR(out[i], render.mean[i], 1e-4f * render.mean[i]);
    }
}

TEST_P(EachDenoiser, FlatNoiseFallsAtLeastTwentyfoldAndLightIsKept) {
    const Extent2D extent{48, 48};
    const Picture truth = Filled(extent, {1, 1, 1, 1});
    const Render render = Noisy(extent, truth, 1.0f, 16);
    const Picture out = Denoise(extent, render, 16);
    EXPECT_GT(SquaredError(render.mean, truth), 20.0 * SquaredError(out, truth));
    double before = 0.0, after = 0.0;
    for (size_t i = 0; i < out.size(); ++i) {
        before += render.mean[i];
        after += out[i];
    }
    EXPECT_NEAR(after / before, 1.0, 2e-3);
}

TEST_P(EachDenoiser, DetailThatNoFeatureHasIsKeptAsSamplesGrow) {
    const Extent2D extent{48, 48};
    const Picture truth = Random(extent, 11, 0.5f, 1.5f);
    for (const uint32_t samples : {2u, 16u, 128u, 1024u, 16384u}) {
        const Render render = Noisy(extent, truth, 1.0f, samples);
        const double before = SquaredError(render.mean, truth);
        EXPECT_LT(SquaredError(Denoise(extent, render, samples), truth),
                  (samples > 512 ? 1.01 : 1.1) * before)
            << samples;
    }
}

// The picture is exact, but said to be noisy, so that what is near is averaged. The regression never
// averages over an edge; the network does, by up to a tenth of a step that is twice as large as the noise.
TEST_P(EachDenoiser, EdgesOfAlbedoAndNormalLeakLittle) {
    const Extent2D extent{32, 32};
    const auto isRight = [](uint32_t x, uint32_t) { return x < 16 ? 0.0f : 1.0f; };
    const Picture truth = Gray(extent, [&](uint32_t x, uint32_t y) { return 1.0f + isRight(x, y); });
    enum class Edge { None, Albedo, Normal };
    const bool isTrained = denoiser == passes::Denoiser::Network;
    for (const Edge edge : {Edge::None, Edge::Albedo, Edge::Normal}) {
        Render render = Noisy(extent, truth, 0.0f, 16);
        const float variance = isTrained ? 4.0f : 400.0f;
        render.variance = Filled(extent, {variance, variance, variance, 0});
        render.firstHalf.clear();
        if (edge == Edge::Albedo)
            render.albedo = Gray(extent, [&](uint32_t x, uint32_t y) { return 0.1f + 0.8f * isRight(x, y); });
        if (edge == Edge::Normal)
            for (uint32_t i = 0; i < 32 * 32; ++i) {
                render.normal[4 * i] = isRight(i % 32, 0);
                render.normal[4 * i + 2] = 1.0f - isRight(i % 32, 0);
            }
        const Picture out = Denoise(extent, render, 16);
        float leak = 0.0f;
        for (size_t i = 0; i < out.size(); ++i) leak = std::max(leak, std::abs(out[i] - truth[i]));
        if (isTrained)
            EXPECT_LT(leak, 0.12f) << int(edge);
        else if (edge == Edge::None)
            EXPECT_GT(leak, 0.2f);  // shows that the noise that is claimed does average
        else
            EXPECT_LT(leak, 0.01f) << int(edge);
    }
}

TEST_P(EachDenoiser, InputsThatAreNotFiniteGiveFinitePictures) {
    const Extent2D extent{21, 13};
    for (const float bad : {kNan, kInfinity, -kInfinity})
        for (Picture Render::*which :
             {&Render::mean, &Render::variance, &Render::albedo, &Render::normal, &Render::firstHalf}) {
            Render render = Noisy(extent, Random(extent, 3, 0.0f, 5.0f), 1.0f, 4);
            for (const size_t pixel : {0u, 100u, 101u, 272u})
                for (size_t c = 0; c < 4; ++c) (render.*which)[4 * pixel + c] = bad;
            for (const float value : Denoise(extent, render, 4)) ASSERT_TRUE(std::isfinite(value));
            if (which == &Render::firstHalf) continue;
            render.firstHalf.clear();
            for (const float value : Denoise(extent, render, 1)) ASSERT_TRUE(std::isfinite(value));
        }
}

TEST_P(EachDenoiser, AnySizeIsDenoised) {
    for (const Extent2D extent : {Extent2D{1, 1}, {1, 7}, {9, 1}, {2, 3}, {17, 33}})
        for (const uint32_t samples : {1u, 16u}) {
            Render render = Noisy(extent, Filled(extent, {1, 1, 1, 1}), 1.0f, 16);
            if (samples == 1) render.firstHalf.clear();
            const Picture out = Denoise(extent, render, samples);
            ASSERT_EQ(out.size(), render.mean.size());
            for (const float value : out) EXPECT_NEAR(value, 1.0f, 1.0f);
        }
}

TEST_F(Denoising, PicturesThatAreTooLargeForTheNetworkGetTheRegression) {
    // The largest planes are 112 halves of each 2 x 2 pixels
    const auto most = static_cast<double>(Device().Info().maxStorageBufferBytes);
    const uint32_t side = 2 * static_cast<uint32_t>(std::sqrt(most / (2 * 112)));
    Renderer& renderer = harness.Graph();
    for (const bool isLarger : {false, true}) {
        const Extent2D extent{isLarger ? side + 2 : side, isLarger ? side + 2 : side};
        EXPECT_EQ(passes::FitsNetwork(Device().Info(), extent), !isLarger);
        renderer.BeginFrame();
        const auto texture = [&](const char* name) {
            TextureId cleared = renderer.CreateTexture(name, {extent, Format::Rgba32Float});
            renderer.AddPass(
                "Clear", PassKind::Transfer, [&](PassBuilder& pass) { cleared = pass.CopiesTo(cleared); },
                [](CommandList&) {});
            return cleared;
        };
        const DenoiseInputs inputs{.mean = texture("mean"),
                                   .variance = texture("variance"),
                                   .albedo = texture("albedo"),
                                   .normal = texture("normal"),
                                   .firstHalf = {},
                                   .seen = {}};
        renderer.Present(passes::Denoise(renderer, inputs, {.samples = 4}));
        renderer.Compile();
        EXPECT_EQ(renderer.DescribePlan().find("NetworkConvolve") == std::string::npos, isLarger);
        renderer.DropFrame();
    }
}

TEST_F(Denoising, WrongInputsAreUsageErrors) {
    const Extent2D extent{4, 4};
    const Render render = Noisy(extent, Filled(extent, {1, 1, 1, 1}), 1.0f, 4);
    EXPECT_THROW(Denoise({4, 4}, render, 1), Error);  // a single sample has no halves
    for (const DenoiseSettings& settings :
         {DenoiseSettings{.samples = 0}, {.samples = 4, .firstSamples = 4}, {.samples = 4}})
        EXPECT_THROW(Noise(extent, render, settings), Error);
    EXPECT_THROW(harness.Run([&](PassHarness& h) {
        DenoiseInputs inputs = Inputs(extent, render);
        inputs.albedo = Texture("small", {2, 2}, Filled({2, 2}, {1, 1, 1, 1}));
        return passes::Denoise(h.Graph(), inputs, {4, 2});
    }),
                 Error);
}

namespace {

struct WithGuides {
    passes::GuideIds guides;
    TextureId denoised;
};

// `settings` have the samples that were accumulated, with their squares.
WithGuides Denoised(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                    const passes::Accumulation& samples) {
    const passes::AccumulatedIds picture = passes::Resolve(renderer, samples, settings.extent, true);
    const passes::GuideIds guides =
        passes::TraceGuides(renderer, scene, settings, picture.mean, picture.variance);
    const TextureId denoised = passes::Denoise(
        renderer,
        {.mean = picture.mean,
         .variance = picture.variance,
         .albedo = guides.albedo,
         .normal = guides.normal,
         .firstHalf = {},  // the mean of the first half of the samples, if it was kept
         .seen = passes::DenoiseInputs::Seen{guides.seen, guides.seenByAll, guides.seenSquares}},
        {.samples = settings.sampleCount});
    return {guides, denoised};
}

}  // namespace

// A black light scatters nothing: what is seen is all of the radiance. Some pixels at its edges are covered
// by less than a sixteenth.
TEST_F(Denoising, SeenIsTheRadianceOfTheSameSamplesAndNearsItsMeanWithFurtherOnes) {
    SceneRender render(Device());
    render.scene.SetScene(SceneOf({QuadMesh(0.5f)}, {Lambert(glm::vec3(0.0f), glm::vec3(4.0f, 2.0f, 1.0f))}));
    const passes::TraceSettings settings = LookAt({0.31f, 0.17f, 3.0f}, {0.31f, 0.17f, 0.0f}, 0.5f, 24);
    const FloatImage truth = render.Render(settings, 4096).mean;
    for (const uint32_t count : {4u, 64u}) {
        passes::Accumulation accumulation(count == 4 ? "few" : "many");
        passes::TraceSettings some = settings;
        some.sampleCount = count;
        render.renderer.BeginFrame();
        const TextureId samples = passes::Trace(render.renderer, render.Declare(), some).radiance;
        render.renderer.Present(
            passes::Accumulate(render.renderer, samples, {.count = count, .height = 24}, accumulation, true)
                .mean);
        render.renderer.Execute();
        render.renderer.BeginFrame();
        const SceneIds ids = render.Declare();
        const auto [guides, denoised] = Denoised(render.renderer, ids, some, accumulation);
        const Readback readbacks[] = {
            render.renderer.ReadBack(guides.seen), render.renderer.ReadBack(guides.seenByAll),
            render.renderer.ReadBack(guides.seenSquares), render.renderer.ReadBack(denoised)};
        render.renderer.Execute();
        const FloatImage mean = render.Render(settings, count).mean, seen = ToFloatImage(readbacks[0]),
                         byAll = ToFloatImage(readbacks[1]), squares = ToFloatImage(readbacks[2]),
                         shown = ToFloatImage(readbacks[3]);
        double before = 0.0, after = 0.0;
        for (size_t i = 0; i < mean.values.size(); ++i) {
            // A light that covers almost all of a pixel may seem to cover all of it
            EXPECT_NEAR(seen.values[i].x, mean.values[i].x, 0.05f * mean.values[i].x + 1e-5f) << count;
            EXPECT_NEAR(squares.values[i].x, 4.0f * seen.values[i].x, 1e-4f) << "the light has 4 or 0";
            EXPECT_NEAR(shown.values[i].x, mean.values[i].x - seen.values[i].x + byAll.values[i].x, 1e-5f);
            before += std::pow(double(mean.values[i].x) - truth.values[i].x, 2);
            after += std::pow(
                double(mean.values[i].x) - seen.values[i].x + byAll.values[i].x - truth.values[i].x, 2);
        }
        EXPECT_LT(1.5 * after, before) << count;
    }
}

}  // namespace raygraph::testing::denoise_test
