// The noise of pictures that do not say theirs, and which verdicts the noise of a reference decides.
#include "editor/session/verify/picture_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "editor/session/verify/verdict.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session::picture_noise_test {

namespace {

class PictureNoiseTest : public testing::VulkanTest {};

// Returns numbers of mean 0 and variance 1 that are as skewed as the light of paths: rarely large.
float Skewed(uint32_t& state) {
    state = state * 1664525u + 1013904223u;
    const float uniform = (float(state >> 8) + 0.5f) * 0x1p-24f;
    return -std::log(uniform) - 1.0f;
}

// A gradient whose noise grows with it, of so many samples a pixel, each with a deviation of 1.5 times the
// mean. Its left eighth is a light without noise.
Picture Gradient(Extent2D size, uint32_t samples, uint32_t seed, bool isVarianceKnown) {
    Picture picture{.name = "gradient", .size = size};
    picture.radiance.assign(4 * PixelCount(size), 1.0f);
    if (isVarianceKnown) {
        picture.variance.assign(picture.radiance.size(), 0.0f);
        picture.samples = samples;
    }
    uint32_t state = seed;
    for (size_t i = 0; i < picture.radiance.size(); ++i) {
        if (i % 4 == 3) continue;
        const size_t x = i / 4 % size.width;
        const float mean = 0.1f + float(x) / float(size.width);
        const float deviation = x < size.width / 8 ? 0.0f : 1.5f * mean / std::sqrt(float(samples));
        picture.radiance[i] = std::max(mean + deviation * Skewed(state), 0.0f);
        if (isVarianceKnown) picture.variance[i] = deviation * deviation;
    }
    return picture;
}

std::string FailedOf(const Verdict& verdict) {
    std::string text;
    for (const VerdictCheck& check : verdict.checks)
        if (!check.isPassed)
            text += ", " + check.name + " " + std::to_string(check.value) + " limit " +
                    std::to_string(check.limit) + " " + check.where;
    return text;
}

void EditPixels(Picture& picture, const std::function<void(uint32_t x, uint32_t y, float& value)>& edit) {
    for (size_t i = 0; i < picture.radiance.size(); ++i)
        if (i % 4 != 3)
            edit(uint32_t(i / 4 % picture.size.width), uint32_t(i / 4 / picture.size.width),
                 picture.radiance[i]);
}

}  // namespace

TEST_F(PictureNoiseTest, NumberOfSamples_IsEstimatedForTheWholePicture) {
    // The last column and row of tiles are one pixel wide
    for (const Extent2D size : {Extent2D{48, 32}, Extent2D{33, 33}, Extent2D{5, 4}}) {
        const Picture reference = Gradient(size, 1024, 1, true);
        for (const uint32_t samples : {16u, 256u}) {
            const PictureNoise noise = NoiseOf(Gradient(size, samples, 7, false), reference);
            EXPECT_TRUE(noise.isEstimated);
            if (size.width > 5) {
                EXPECT_NEAR(std::log2(2.0 * noise.samples / samples), 0.0, 0.6) << size.width;
            }
        }
        EXPECT_EQ(NoiseOf(Gradient(size, 16, 7, false), reference, {}, 64).samples, 64.0);
        EXPECT_EQ(NoiseOf(Gradient(size, 16, 7, false), reference, {}, 0).variance,
                  Texels(4 * PixelCount(size), 0.0f));
        EXPECT_GE(NoiseOf(Gradient(size, 1, 7, false), reference).samples, kLeastPictureSamples);
    }
    // Without any noise to go by there is none
    Picture exact = Gradient({48, 32}, 1024, 1, true);
    exact.variance.clear();
    EXPECT_EQ(NoiseOf(Gradient({48, 32}, 16, 7, false), exact).variance, Texels(4 * 48 * 32, 0.0f));
}

TEST_F(PictureNoiseTest, NoiseIsRight_AndPatternsAreNot) {
    Renderer renderer(Device());
    for (const Extent2D size : {Extent2D{48, 32}, Extent2D{33, 33}}) {
        const Picture reference = Gradient(size, 1024, 1, true);
        const auto judge = [&](const Picture& picture) {
            return Judge(renderer, picture, {.reference = reference});
        };
        for (const uint32_t samples : {16u, 64u, 256u})
            for (uint32_t seed = 5; seed < 8; ++seed) {
                const Verdict verdict = judge(Gradient(size, samples, seed, false));
                EXPECT_TRUE(verdict.isRight) << samples << " samples, seed " << seed << FailedOf(verdict);
            }
        const auto edited = [&](uint32_t samples, const auto& edit) {
            Picture picture = Gradient(size, samples, 7, false);
            EditPixels(picture, edit);
            return judge(picture).isRight;
        };
        for (const uint32_t samples : {64u, 1024u}) {
            EXPECT_FALSE(edited(samples, [](uint32_t x, uint32_t y, float& value) {
                value *= (x + y) % 2 == 0 ? 1.4f : 0.6f;
            })) << samples;
            EXPECT_FALSE(edited(samples, [](uint32_t x, uint32_t y, float& value) {
                value *= (x / 2 + y / 2) % 2 == 0 ? 1.4f : 0.6f;
            })) << samples;
            EXPECT_FALSE(edited(samples, [](uint32_t x, uint32_t y, float& value) {
                if (x % 2 == 0 && y % 2 == 0) value = 0.0f;
            })) << samples;
            EXPECT_FALSE(edited(samples, [](uint32_t x, uint32_t y, float& value) {
                if ((x + 3 * y) % 4 == 0) value = 0.0f;
            })) << samples;
        }
        // Pixels that were enlarged twice
        const Picture small = Gradient(size, 16, 7, false);
        Picture large = small;
        EditPixels(large, [&](uint32_t x, uint32_t y, float& value) {
            const size_t c = size_t(&value - large.radiance.data()) % 4;
            value = small.radiance[4 * ((y / 2 * 2) * size.width + x / 2 * 2) + c];
        });
        EXPECT_FALSE(judge(large).isRight);
    }
}

// The verdict that is decided with few samples of the reference is that with many.
TEST_F(PictureNoiseTest, Decided_IsWhatMoreSamplesOfTheReferenceConfirm) {
    Renderer renderer(Device());
    const Extent2D size{48, 32};
    size_t decided = 0, undecided = 0;
    for (uint32_t seed = 1; seed <= 6; ++seed)
        for (const float gain : {1.0f, 1.03f, 1.06f, 1.1f, 1.5f}) {
            Picture picture = Gradient(size, 1024, 100 + seed, true);
            EditPixels(picture, [&](uint32_t, uint32_t, float& value) { value *= gain; });
            const auto judge = [&](uint32_t samples) {
                const Picture reference = Gradient(size, samples, seed, true);
                return Judge(renderer, picture, {.reference = reference});
            };
            const Verdict few = judge(64), many = judge(16384);
            EXPECT_EQ(many.isRight, gain < 1.02f) << gain;
            ++(few.isDecided ? decided : undecided);
            if (few.isDecided) {
                EXPECT_EQ(few.isRight, many.isRight) << "seed " << seed << ", gain " << gain << FailedOf(few);
            }
        }
    EXPECT_GE(decided, 6u);
    EXPECT_GE(undecided, 6u);
}

}  // namespace raygraph::session::picture_noise_test
