// Tests the network of the denoiser: its passes against the same computation in double precision, for
// weights at random.
#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <random>

#include "passes/denoise_network.h"
#include "renderer/graph/pass_harness.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::network_test {

namespace {

using Picture = std::vector<float>;  // RGBA

// Channels of a picture, one after the other.
struct Planes {
    int width = 0, height = 0;
    std::vector<std::vector<double>> channels;

    Planes(int w, int h, size_t count)
        : width(w), height(h), channels(count, std::vector<double>(size_t(w) * size_t(h))) {}
    double& At(size_t channel, int x, int y) {
        return channels[channel][size_t(y) * size_t(width) + size_t(x)];
    }
    double Clamped(size_t channel, int x, int y) const {
        x = std::clamp(x, 0, width - 1);
        y = std::clamp(y, 0, height - 1);
        return channels[channel][size_t(y) * size_t(width) + size_t(x)];
    }
};

int Half(int size) {
    return (size + 1) / 2;
}

struct Pictures {
    Extent2D extent;
    Picture mean, target, noise, albedo, normal;

    explicit Pictures(Extent2D size) : extent(size) {
        auto fill = [&, seed = 1u](float least, float most) mutable {
            std::mt19937 generator(seed++);
            std::uniform_real_distribution<float> uniform(least, most);
            Picture picture(size_t{4} * size.width * size.height);
            for (float& value : picture) value = uniform(generator);
            return picture;
        };
        mean = fill(0.0f, 3.0f);
        target = fill(-0.1f, 3.0f);
        noise = fill(0.0f, 0.5f);
        albedo = fill(0.0f, 1.0f);
        normal = fill(-1.0f, 1.0f);
    }
    double At(const Picture& picture, int x, int y, int c) const {
        return picture[4 * (size_t(y) * extent.width + size_t(x)) + size_t(c)];
    }
};

std::vector<uint16_t> RandomWeights(uint32_t seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<float> normal(0.0f, 0.06f);
    std::vector<uint16_t> weights(passes::NetworkWeightCount());
    for (uint16_t& weight : weights) weight = glm::packHalf1x16(normal(generator));
    return weights;
}

// The network as its papers have it, one pixel and channel after the other.
class Reference {
  public:
    Reference(const Pictures& pictures, std::vector<uint16_t> weights, uint32_t samples)
        : m_in(pictures), m_weights(std::move(weights)), m_samples(samples) {}

    Picture Run() {
        std::vector<Planes> lights{Light()};
        for (int i = 0; i < 3; ++i) lights.push_back(Halved(lights.back()));
        const size_t widths[] = {64, 80, 88, 80};
        Planes planes = Features(lights[0]);
        std::vector<Planes> skips;
        for (int level = 0; level < 4; ++level) {
            planes = Convolve(planes, nullptr, widths[level], 3, level > 0 ? 2 : 1);
            planes = Convolve(planes, nullptr, widths[level], 3, 1);
            skips.push_back(planes);
        }
        Planes result = Apply(Convolve(planes, nullptr, 112, 1, 1), lights[3], nullptr);
        for (int level = 3; level-- > 0;) {
            planes = Convolve(planes, &skips[size_t(level)], widths[level], 3, 1);
            planes = Convolve(planes, nullptr, widths[level], 3, 1);
            result = Apply(Convolve(planes, nullptr, 112, 1, 1), lights[size_t(level)], &result);
        }
        EXPECT_EQ(m_next, m_weights.size());
        return Colored(result);
    }

  private:
    double Radiance(int x, int y, int c) const { return std::max(m_in.At(m_in.target, x, y, c), 0.0); }
    Planes Light() const {
        Planes light(int(m_in.extent.width), int(m_in.extent.height), 3);
        for (int y = 0; y < light.height; ++y)
            for (int x = 0; x < light.width; ++x)
                for (int c = 0; c < 3; ++c)
                    light.At(size_t(c), x, y) = Radiance(x, y, c) / (m_in.At(m_in.albedo, x, y, c) + 0.02);
        return light;
    }
    double Exposure() const {
        double sum = 0.0, roots = 0.0;
        for (int y = 0; y < int(m_in.extent.height); ++y)
            for (int x = 0; x < int(m_in.extent.width); ++x) {
                const double luminance =
                    std::max(0.2126 * m_in.At(m_in.target, x, y, 0) + 0.7152 * m_in.At(m_in.target, x, y, 1) +
                                 0.0722 * m_in.At(m_in.target, x, y, 2),
                             0.0);
                sum += luminance;
                roots += std::sqrt(luminance);
            }
        return roots * roots / (sum * sum);
    }
    Planes Features(const Planes& light) const {
        const double scale = Exposure();
        Planes planes(Half(light.width), Half(light.height), 64);
        for (int y = 0; y < planes.height; ++y)
            for (int x = 0; x < planes.width; ++x)
                for (int i = 0; i < 4; ++i) {
                    const int px = std::min(2 * x + i % 2, light.width - 1);
                    const int py = std::min(2 * y + i / 2, light.height - 1);
                    double radiance = 0.0, deviation = 0.0, squares = 0.0;
                    for (int c = 0; c < 3; ++c) {
                        radiance += Radiance(px, py, c) / 3.0;
                        deviation += std::sqrt(m_in.At(m_in.noise, px, py, c)) / 3.0;
                        const double n = m_in.At(m_in.normal, px, py, c);
                        squares += n * n;
                        const size_t first = 16 * size_t(i) + size_t(c);
                        planes.At(first, x, y) = std::log1p(scale * light.Clamped(size_t(c), px, py));
                        planes.At(first + 3, x, y) = std::log1p(scale * Radiance(px, py, c));
                        planes.At(first + 8, x, y) = m_in.At(m_in.albedo, px, py, c);
                        planes.At(first + 11, x, y) = n;
                    }
                    const size_t first = 16 * size_t(i);
                    planes.At(first + 6, x, y) = std::log1p(scale * deviation);
                    planes.At(first + 7, x, y) = std::log1p(deviation / (radiance + 0.01 / scale));
                    planes.At(first + 14, x, y) = squares;
                    planes.At(first + 15, x, y) = 1.0 / std::sqrt(double(m_samples));
                }
        return planes;
    }
    static Planes Halved(const Planes& finer) {
        Planes coarser(Half(finer.width), Half(finer.height), 3);
        for (size_t c = 0; c < 3; ++c)
            for (int y = 0; y < coarser.height; ++y)
                for (int x = 0; x < coarser.width; ++x)
                    for (int i = 0; i < 4; ++i)
                        coarser.At(c, x, y) += 0.25 * finer.Clamped(c, 2 * x + i % 2, 2 * y + i / 2);
        return coarser;
    }
    double NextWeight() { return glm::unpackHalf1x16(m_weights[m_next++]); }

    Planes Convolve(const Planes& source, const Planes* skip, size_t channels, int taps, int stride) {
        Planes result = skip          ? Planes(skip->width, skip->height, channels)
                        : stride == 2 ? Planes(Half(source.width), Half(source.height), channels)
                                      : Planes(source.width, source.height, channels);
        const size_t sources = source.channels.size(), inputs = sources + (skip ? skip->channels.size() : 0);
        for (size_t group = 0; group < channels; group += 8) {
            double bias[8];
            for (double& value : bias) value = NextWeight();
            std::vector<double> weights(inputs * size_t(taps * taps) * 8);
            for (double& value : weights) value = NextWeight();
            for (int y = 0; y < result.height; ++y)
                for (int x = 0; x < result.width; ++x)
                    for (size_t c = 0; c < 8; ++c) {
                        double sum = bias[c];
                        for (size_t i = 0; i < inputs; ++i)
                            for (int tap = 0; tap < taps * taps; ++tap) {
                                const int at_x = stride * x + tap % taps - taps / 2;
                                const int at_y = stride * y + tap / taps - taps / 2;
                                const double value =
                                    i >= sources ? skip->Clamped(i - sources, at_x, at_y)
                                    : skip ? source.Clamped(i, std::max(at_x, 0) / 2, std::max(at_y, 0) / 2)
                                           : source.Clamped(i, at_x, at_y);
                                const size_t block = i / 4 * size_t(taps * taps) + size_t(tap);
                                sum += value * weights[(block * 4 + i % 4) * 8 + c];
                            }
                        result.At(group + c, x, y) = taps == 1 ? sum : std::max(sum, 0.1 * sum);
                    }
        }
        return result;
    }

    static Planes Apply(const Planes& kernels, const Planes& light, const Planes* coarser) {
        Planes filtered(light.width, light.height, 3), result(light.width, light.height, 3);
        const auto pixelOf = [&](int x, int y) { return 28 * size_t(x % 2 + 2 * (y % 2)); };
        for (int y = 0; y < light.height; ++y)
            for (int x = 0; x < light.width; ++x) {
                double weights = 0.0;
                for (int tap = 0; tap < 25; ++tap) {
                    const double weight =
                        std::exp(kernels.Clamped(pixelOf(x, y) + size_t(tap), x / 2, y / 2));
                    weights += weight;
                    for (size_t c = 0; c < 3; ++c)
                        filtered.At(c, x, y) += weight * light.Clamped(c, x + tap % 5 - 2, y + tap / 5 - 2);
                }
                for (size_t c = 0; c < 3; ++c) filtered.At(c, x, y) /= weights;
            }
        if (!coarser) return filtered;
        for (int y = 0; y < light.height; ++y)
            for (int x = 0; x < light.width; ++x) {
                const double share =
                    1.0 / (1.0 + std::exp(-kernels.Clamped(pixelOf(x, y) + 25, x / 2, y / 2)));
                for (size_t c = 0; c < 3; ++c) {
                    double blurred = 0.0, above = 0.0;
                    for (int i = 0; i < 4; ++i) {
                        blurred += 0.25 * filtered.Clamped(c, x / 2 * 2 + i % 2, y / 2 * 2 + i / 2);
                        const int cx = (x + 1) / 2 - 1 + i % 2, cy = (y + 1) / 2 - 1 + i / 2;
                        const double wx = (x % 2 == 0) == (i % 2 == 1) ? 0.75 : 0.25;
                        const double wy = (y % 2 == 0) == (i / 2 == 1) ? 0.75 : 0.25;
                        above += wx * wy * coarser->Clamped(c, cx, cy);
                    }
                    result.At(c, x, y) = filtered.Clamped(c, x, y) + share * (above - blurred);
                }
            }
        return result;
    }
    Picture Colored(const Planes& light) const {
        Picture picture;
        for (int y = 0; y < light.height; ++y)
            for (int x = 0; x < light.width; ++x) {
                for (int c = 0; c < 3; ++c)
                    picture.push_back(float(std::max(light.Clamped(size_t(c), x, y), 0.0) *
                                                (m_in.At(m_in.albedo, x, y, c) + 0.02) +
                                            m_in.At(m_in.mean, x, y, c) - m_in.At(m_in.target, x, y, c)));
                picture.push_back(0.0f);
            }
        return picture;
    }

    const Pictures& m_in;
    std::vector<uint16_t> m_weights;
    uint32_t m_samples;
    size_t m_next = 0;
};

class Network : public VulkanTest {
  protected:
    Picture Predict(const Pictures& in, std::span<const uint16_t> weights, uint32_t samples) {
        return harness
            .Run([&](PassHarness& h) {
                const auto texture = [&](const char* name, const Picture& picture) {
                    return h.Texture(name, in.extent, Format::Rgba32Float, picture);
                };
                return passes::PredictDenoised(h.Graph(),
                                               {.mean = texture("mean", in.mean),
                                                .target = texture("target", in.target),
                                                .noise = texture("noise", in.noise),
                                                .albedo = texture("albedo", in.albedo),
                                                .normal = texture("normal", in.normal),
                                                .samples = samples},
                                               weights);
            })
            .values;
    }
    PassHarness harness{Device()};
};

}  // namespace

TEST_F(Network, EveryPixelIsThatOfTheComputationInDoublePrecision) {
    const std::vector<uint16_t> weights = RandomWeights(5);
    for (const Extent2D extent : {Extent2D{40, 23}, {16, 16}, {1, 1}, {3, 2}}) {
        const Pictures in(extent);
        const Picture expected = Reference(in, weights, 16).Run(), predicted = Predict(in, weights, 16);
        ASSERT_EQ(predicted.size(), expected.size());
        for (size_t i = 0; i < expected.size(); ++i) {
            if (i % 4 == 3) continue;
            ASSERT_NEAR(predicted[i], expected[i], 0.01f * std::abs(expected[i]) + 0.01f)
                << extent.width << "x" << extent.height << ", " << i / 4 << ", channel " << i % 4;
        }
    }
}

TEST_F(Network, OtherNumbersOfWeightsAreUsageErrors) {
    std::vector<uint16_t> weights = RandomWeights(5);
    weights.pop_back();
    EXPECT_THROW(Predict(Pictures({4, 4}), weights, 1), Error);
}

// The gain that the trained weights bring is measured by measure.py; this shows that they are those of
// these passes.
TEST_F(Network, TrainedWeightsRemoveNoiseOfAFlatPicture) {
    Pictures in({48, 48});
    std::mt19937 generator(9);
    std::normal_distribution<float> noise(0.0f, 0.5f);
    for (size_t i = 0; i < in.mean.size(); ++i) {
        in.mean[i] = in.target[i] = 2.0f + noise(generator);
        in.noise[i] = 0.25f;
        in.albedo[i] = 0.5f;
        in.normal[i] = i % 4 == 2 ? 1.0f : 0.0f;
    }
    double before = 0.0, after = 0.0;
    const Picture out = Predict(in, passes::TrainedWeights(), 16);
    for (size_t i = 0; i < out.size(); ++i) {
        if (i % 4 == 3) continue;
        before += std::pow(in.mean[i] - 2.0, 2);
        after += std::pow(out[i] - 2.0, 2);
    }
    EXPECT_LT(30.0 * after, before);
}

// Predicts the same picture under a light that is a thousand times as bright.
TEST_F(Network, EstimateFollowsTheExposure) {
    const Pictures in({40, 23});
    Pictures bright = in;
    for (Picture Pictures::*which : {&Pictures::mean, &Pictures::target})
        for (float& value : bright.*which) value *= 1024.0f;
    for (float& value : bright.noise) value *= 1024.0f * 1024.0f;
    const Picture expected = Predict(in, passes::TrainedWeights(), 16);
    const Picture out = Predict(bright, passes::TrainedWeights(), 16);
    for (size_t i = 0; i < out.size(); ++i) {
        if (i % 4 == 3) continue;
        ASSERT_NEAR(out[i] / 1024.0f, expected[i], 1e-3f * std::abs(expected[i]) + 1e-3f);
    }
}

}  // namespace raygraph::testing::network_test
