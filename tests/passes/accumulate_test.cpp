#include <gtest/gtest.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <tuple>
#include <type_traits>

#include "base/error.h"
#include "core/tonemap.glsl"
#include "passes/accumulate.h"
#include "passes/tonemap.h"
#include "renderer/graph/pass_harness.h"
#include "tests/support/error_of.h"
#include "tests/support/option_rows.h"
#include "tests/support/vulkan_test.h"

// Accumulate alone: hand-made samples in, mean and variance out.
namespace raygraph::testing::accumulate_test {

using passes::Accumulation;
using passes::ExactSums;
using passes::ResetCause;

namespace {

constexpr Extent2D kExtent{2, 1};

class AccumulateTest : public VulkanTest {
  protected:
    // Takes a sample of two texels into the open frame; the variance with it.
    static TextureId AddForVariance(PassHarness& h, Accumulation& into, const std::vector<float>& sample) {
        const TextureId texture = h.Texture("sample", kExtent, Format::Rgba32Float, sample);
        std::ignore = passes::Accumulate(h.Graph(), texture, into, true);
        return passes::Resolve(h.Graph(), into, kExtent, true).variance;
    }
    // One frame: takes a sample and returns the mean, or the variance.
    Texels Add(const std::vector<float>& sample, bool wantsVariance = false) {
        return harness.Run([&](PassHarness& h) {
            if (wantsVariance) return AddForVariance(h, accumulation, sample);
            const TextureId texture = h.Texture("sample", kExtent, Format::Rgba32Float, sample);
            return passes::Accumulate(h.Graph(), texture, accumulation).mean;
        });
    }
    struct Both {
        Texels mean, variance;
    };
    Both AddForBoth(const std::vector<float>& sample) {
        Texels variance = Add(sample, true);
        return {harness.Run([&](PassHarness& h) {
                    return passes::StoredAccumulation(h.Graph(), accumulation, kExtent, true).mean;
                }),
                std::move(variance)};
    }
    ExactSums KeptSums() {
        ExactSums sums;
        for (const bool isSquares : {false, true})
            for (size_t k = 0; k < ExactSums::kPlanes; ++k) {
                Readback readback;
                harness.Run([&](PassHarness& h) {
                    const passes::AccumulatedIds ids =
                        passes::StoredAccumulation(h.Graph(), accumulation, kExtent, true);
                    readback = h.Graph().ReadBack(isSquares ? ids.squares[k] : ids.sums[k]);
                    return ids.mean;
                });
                ExactSums::Plane& plane = isSquares ? sums.squares[k] : sums.sums[k];
                plane.resize(8);
                std::memcpy(plane.data(), readback.Bytes().data(), 32);
            }
        return sums;
    }
    // A sample that differs by texel, channel and number.
    static std::vector<float> Sample(uint32_t number) {
        std::vector<float> values(8);
        for (uint32_t i = 0; i < 8; ++i) values[i] = float((number * 7 + i * 3) % 11) * (0.5f + float(i));
        return values;
    }

    PassHarness harness{Device()};
    Accumulation accumulation{"image"};
};

}  // namespace

TEST_F(AccumulateTest, Accumulate_GivesTheNearestMeanAndUnbiasedVariance) {
    constexpr uint32_t kCount = 9;
    Texels mean, variance;
    for (uint32_t n = 0; n < kCount; ++n) variance = Add(Sample(n), true);
    ASSERT_EQ(accumulation.SampleCount(), kCount);
    mean = Add(Sample(kCount));
    for (uint32_t i = 0; i < 8; ++i) {
        double sum = 0.0, squares = 0.0;
        for (uint32_t n = 0; n < kCount; ++n) sum += Sample(n)[i];
        for (uint32_t n = 0; n < kCount; ++n) squares += std::pow(Sample(n)[i] - sum / kCount, 2);
        EXPECT_FLOAT_EQ(variance.values[i], i % 4 == 3 ? 0.0f : float(squares / (kCount - 1)));
        EXPECT_EQ(mean.values[i], float((sum + Sample(kCount)[i]) / (kCount + 1)));
    }
}

TEST_F(AccumulateTest, Accumulate_TheVarianceLeavesTheBitsOfTheMean) {
    Accumulation other("other");
    for (uint32_t n = 0; n < 5; ++n) {
        const Texels mean = Add(Sample(n));
        const Texels beside = harness.Run([&](PassHarness& h) {
            const TextureId texture = h.Texture("sample", kExtent, Format::Rgba32Float, Sample(n));
            return passes::Accumulate(h.Graph(), texture, other, true).mean;
        });
        EXPECT_EQ(mean.values, beside.values) << n;
    }
    EXPECT_EQ(accumulation.SampleCount(), other.SampleCount());
}

TEST_F(AccumulateTest, Accumulate_FirstSampleIgnoresWhatWasStored) {
    Add({NAN, NAN, NAN, NAN, 1, 1, 1, 1}, true);
    accumulation.Reset(ResetCause::Camera);
    EXPECT_EQ(accumulation.ResetCount(ResetCause::Camera), 1u);
    EXPECT_EQ(accumulation.ResetCount(ResetCause::Transform), 0u);
    const Texels mean = Add({1, 2, 3, 4, 5, 6, 7, 8});
    EXPECT_EQ(mean.values, (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8}));
    EXPECT_EQ(accumulation.SampleCount(), 1u);
}

TEST_F(AccumulateTest, Accumulate_WhatIsNotFiniteCountsAsZero) {
    Add({1, 1, 1, 1, 2, 2, 2, 2});
    Add({NAN, 1, INFINITY, -INFINITY, 4, 4, 4, 4});
    const Texels mean = Add({2, 1, 2, 2, 6, 6, 6, 6});
    EXPECT_EQ(mean.values, (std::vector<float>{1, 1, 1, 1, 4, 4, 4, 4}));
}

TEST_F(AccumulateTest, Accumulate_EqualSamplesHaveNoVariance) {
    Texels variance;
    for (int n = 0; n < 7; ++n) variance = Add({0.1f, 1e4f, 1e10f, 1, 0.3f, -0.7f, 0.01f, 0}, true);
    EXPECT_EQ(variance.values, std::vector<float>(8, 0.0f));
}

// A pixel of 1 that a rare path adds 20 to. The recurrence mean += (x - mean) / n in float32 loses most of
// the way back from each: it stands 2 % too high in the end.
TEST_F(AccumulateTest, Accumulate_SkewedPixelDoesNotDriftInAMillionSamples) {
    constexpr uint32_t kMillion = 1000000, kOnTheHost = kMillion - 16;
    const auto value = [](uint32_t n) { return ((n * 2654435761u) >> 8) % 1000 == 0 ? 21.0f : 1.0f; };
    double sum = 0.0, squares = 0.0;
    float recurrence = 0.0f;
    ExactSums sums = passes::MakeExactSums(2, true);
    for (uint32_t n = 0; n < kMillion; ++n) {
        const float x = value(n);
        sum += x;
        squares += double{x} * x;
        recurrence += (x - recurrence) / float(n + 1);
        if (n < kOnTheHost) passes::AddSample(sums, std::vector<float>(8, x));
    }
    ASSERT_GT(recurrence, 1.02 * sum / kMillion) << "the sequence is no test of anything";
    harness.Run([&](PassHarness& h) {
        passes::Restore(h.Graph(), accumulation, kExtent, kOnTheHost, sums);
        return h.Texture("nothing", {1, 1}, Format::R32Float, {0.0f});
    });
    Both both;
    for (uint32_t n = kOnTheHost; n < kMillion; ++n) both = AddForBoth(std::vector<float>(8, value(n)));
    ASSERT_EQ(accumulation.SampleCount(), kMillion);
    EXPECT_EQ(both.mean.values[0], float(sum / kMillion));
    EXPECT_FLOAT_EQ(both.variance.values[0], float((squares - sum * sum / kMillion) / (kMillion - 1)));
}

// From far below the moon's light to the sun's disk, of both signs, and what has to be saturated.
std::vector<float> WideSample(uint32_t number) {
    std::mt19937 random(number);
    std::vector<float> values(8);
    for (float& value : values) {
        const auto bits = static_cast<uint32_t>(random() & 0x807FFFFFu);
        const auto exponent = static_cast<uint32_t>(67 + random() % 105);
        value = std::bit_cast<float>(bits | exponent << 23);
    }
    return values;
}

TEST_F(AccumulateTest, Accumulate_HasTheBitsOfTheHost) {
    ExactSums sums = passes::MakeExactSums(2, true);
    for (uint32_t n = 0; n < 12; ++n) {
        const auto [mean, variance] = AddForBoth(WideSample(n));
        passes::AddSample(sums, WideSample(n));
        EXPECT_EQ(mean.values, passes::MeanOf(sums, n + 1)) << n;
        EXPECT_EQ(variance.values, passes::VarianceOf(sums, n + 1)) << n;
    }
    EXPECT_EQ(KeptSums(), sums);
}

TEST_F(AccumulateTest, Restore_ContinuesBitForBit) {
    for (uint32_t n = 0; n < 5; ++n) AddForBoth(WideSample(n));
    const ExactSums stored = KeptSums();

    PassHarness other(Device());
    Accumulation continued("image");
    other.Run([&](PassHarness& h) {
        passes::Restore(h.Graph(), continued, kExtent, 5, stored);
        return h.Texture("nothing", {1, 1}, Format::R32Float, {0.0f});
    });
    EXPECT_EQ(continued.SampleCount(), 5u);
    const Texels restored = other.Run(
        [&](PassHarness& h) { return passes::Resolve(h.Graph(), continued, kExtent, true).variance; });
    EXPECT_EQ(restored.values, passes::VarianceOf(stored, 5));
    const Texels expected = Add(WideSample(5), true);
    const Texels actual =
        other.Run([&](PassHarness& h) { return AddForVariance(h, continued, WideSample(5)); });
    EXPECT_EQ(actual.values, expected.values);
    EXPECT_EQ(continued.SampleCount(), 6u);
}

TEST_F(AccumulateTest, Restore_RefusesStateOfAnotherExtent) {
    EXPECT_THROW(harness.Run([&](PassHarness& h) {
        passes::Restore(h.Graph(), accumulation, kExtent, 5, passes::MakeExactSums(1, false));
        return h.Texture("nothing", {1, 1}, Format::R32Float, {0.0f});
    }),
                 Error);
}

TEST(ExactSums, NeitherOrderNorGroupingOfSamplesShows) {
    const auto sumOf = [](std::vector<uint32_t> numbers) {
        ExactSums sums = passes::MakeExactSums(2, true);
        for (const uint32_t n : numbers) passes::AddSample(sums, WideSample(n));
        return sums;
    };
    const ExactSums whole = sumOf({0, 1, 2, 3, 4, 5, 6, 7});
    ExactSums parts = sumOf({6, 3, 5, 4, 7});
    passes::AddSums(parts, sumOf({2, 1}));
    passes::AddSums(parts, sumOf({0}));
    EXPECT_EQ(parts, whole);
    EXPECT_EQ(passes::VarianceOf(parts, 8), passes::VarianceOf(whole, 8));
    EXPECT_THROW(passes::AddSums(parts, passes::MakeExactSums(2, false)), Error);
    EXPECT_THROW(passes::AddSums(parts, passes::MakeExactSums(3, true)), Error);
}

TEST(ExactSums, RecordsAddUpLikeTheSumsThatTheyAreOf) {
    constexpr size_t kPixels = 3;
    for (const bool withSquares : {true, false}) {
        SCOPED_TRACE(withSquares);
        const auto sumsOf = [&](uint32_t seed) {
            // Any words at all, so that carries go from each word to the next
            std::mt19937 generator(seed);
            ExactSums sums = passes::MakeExactSums(kPixels, withSquares);
            const auto fill = [&](auto& planes, bool hasUnused) {
                for (auto& plane : planes)
                    for (size_t i = 0; i < plane.size(); ++i)
                        if (!hasUnused || i % 4 != 3 || &plane != &planes.back())
                            plane[i] = static_cast<uint32_t>(generator());
            };
            fill(sums.sums, false);
            if (withSquares) fill(sums.squares, true);
            return sums;
        };
        const ExactSums others = sumsOf(2);
        ExactSums sums = sumsOf(1);
        const size_t words = passes::WordsOfRecord(withSquares);
        EXPECT_EQ(words, withSquares ? 31u : 16u);
        std::vector<uint32_t> records(kPixels * words), added(kPixels * words);
        passes::PackSums(sums, 0, records);
        passes::PackSums(others, 0, added);
        ExactSums back = passes::MakeExactSums(kPixels, withSquares);
        passes::UnpackSums(records, 0, back);
        EXPECT_EQ(back, sums);

        passes::AddRecords(records, added, withSquares);
        passes::UnpackSums(records, 0, back);
        passes::AddSums(sums, others);
        EXPECT_EQ(back, sums);

        // A part of the pixels, which leaves the others
        std::vector<uint32_t> last(words);
        passes::PackSums(others, 2, last);
        EXPECT_EQ(last, (std::vector<uint32_t>(added.end() - static_cast<ptrdiff_t>(words), added.end())));
        passes::UnpackSums(last, 1, back);
        for (size_t i = 0; i < 4 * kPixels; ++i)
            EXPECT_EQ(back.sums[1][i], i / 4 == 1 ? others.sums[1][i + 4] : sums.sums[1][i]) << i;
    }
}

// So large that several threads work on it, and of a number of pixels that they cannot share evenly.
TEST(ExactSums, LargePicturesHaveTheBitsOfSmallOnes) {
    constexpr size_t kSmall = 1009, kLarge = 3 * 65536 + 7;
    std::mt19937 generator(1);
    const auto sumsOf = [&](uint32_t count) {
        ExactSums sums = passes::MakeExactSums(kSmall, true);
        std::vector<float> sample(4 * kSmall);
        for (uint32_t n = 0; n < count; ++n) {
            for (float& value : sample) value = std::uniform_real_distribution<float>(-1, 1)(generator);
            passes::AddSample(sums, sample);
        }
        return sums;
    };
    // Pixel i of the large picture is pixel i % kSmall of the small one
    const auto repeated = [](const auto& small) {
        std::remove_cvref_t<decltype(small)> large(4 * kLarge);
        for (size_t i = 0; i < large.size(); ++i) large[i] = small[i % small.size()];
        return large;
    };
    const auto enlarged = [&](const ExactSums& small) {
        ExactSums large;
        for (size_t k = 0; k < ExactSums::kPlanes; ++k) {
            large.sums[k] = repeated(small.sums[k]);
            large.squares[k] = repeated(small.squares[k]);
        }
        return large;
    };
    ExactSums sums = sumsOf(3);
    const ExactSums others = sumsOf(2);
    ExactSums large = enlarged(sums);
    passes::AddSums(large, enlarged(others));
    passes::AddSums(sums, others);
    EXPECT_TRUE(large == enlarged(sums));
    EXPECT_TRUE(passes::MeanOf(large, 5) == repeated(passes::MeanOf(sums, 5)));
    EXPECT_TRUE(passes::VarianceOf(large, 5) == repeated(passes::VarianceOf(sums, 5)));
}

TEST(ExactSums, KeepTheMoonlightBesideTheSunForTenMillionSamples) {
    // Doubled 23 times: 8.4e6 samples
    ExactSums sums = passes::MakeExactSums(1, true);
    passes::AddSample(sums, std::vector<float>{1e-6f, 1e10f, -1e10f, 1.0f});
    uint32_t count = 1;
    for (; count < (1u << 23); count *= 2) passes::AddSums(sums, ExactSums(sums));
    EXPECT_EQ(passes::MeanOf(sums, count), (std::vector<float>{1e-6f, 1e10f, -1e10f, 1.0f}));
    for (const float variance : passes::VarianceOf(sums, count)) EXPECT_LT(variance, 1e-20f);
    passes::AddSample(sums, std::vector<float>{1e10f, 1e-6f, 1e10f, 0.0f});
    EXPECT_FLOAT_EQ(passes::MeanOf(sums, count + 1)[0], float((1e10 + 1e-6 * count) / (count + 1)));
    EXPECT_FLOAT_EQ(passes::VarianceOf(sums, count + 1)[1], float(1e20 / (count + 1)));
}

// Twice the distance of mean * count from the sum is no more than a step of the mean times count, and where
// it is as much the mean is even. All in integers.
TEST(ExactSums, MeanIsTheFloatNearestToTheQuotient) {
    __extension__ using Wide = unsigned __int128;
    std::mt19937_64 generator(1);
    for (int i = 0; i < 200'000; ++i) {
        const auto count = std::max(uint32_t(generator()) >> (generator() % 32), 1u);
        Wide sum = ((Wide{generator()} << 64) | generator()) >> (1 + generator() % 100);
        if (i % 4 == 0) sum = Wide{(generator() & 0xFFFFFFu) * 2 + 0x2000001u} * count << (generator() % 60);
        if (i % 4 == 1) sum -= sum % count;
        ExactSums sums = passes::MakeExactSums(1, false);
        for (int k = 0; k < 4; ++k) sums.sums[k][0] = uint32_t(sum >> (32 * k));
        const float mean = passes::MeanOf(sums, count)[0];
        if (sum < count) continue;  // means below a unit need more bits than the check has
        int exponent = 0;
        const auto mantissa = uint32_t(std::ldexp(std::frexp(mean, &exponent), 24));
        exponent += 64 - 24;  // mean = mantissa * 2^exponent units
        const int up = std::max(exponent, 0), down = std::max(-exponent, 0);
        const Wide product = Wide{mantissa} * count << up, scaled = sum << down;
        const Wide distance = product > scaled ? product - scaled : scaled - product;
        const Wide step = Wide{count} << up;
        ASSERT_LE(2 * distance, step) << mean << ", sample " << i;
        ASSERT_TRUE(2 * distance < step || mantissa % 2 == 0) << mean << ", a tie, sample " << i;
    }
}

TEST_F(AccumulateTest, Accumulate_ResizeResetsWithItsCause) {
    Add(Sample(0));
    Add(Sample(1));
    const Texels mean = harness.Run([&](PassHarness& h) {
        const TextureId texture = h.Texture("sample", {1, 1}, Format::Rgba32Float, {3, 3, 3, 3});
        return passes::Accumulate(h.Graph(), texture, accumulation).mean;
    });
    EXPECT_EQ(mean.values, (std::vector<float>{3, 3, 3, 3}));
    EXPECT_EQ(accumulation.SampleCount(), 1u);
    EXPECT_EQ(accumulation.ResetCount(ResetCause::Resize), 1u);
}

TEST_F(AccumulateTest, Accumulate_VarianceNeverMissesSamples) {
    for (uint32_t n = 0; n < 3; ++n) Add(Sample(n));
    const Texels variance = Add(Sample(3), true);
    EXPECT_EQ(accumulation.SampleCount(), 1u) << "three samples have no variance: restart";
    EXPECT_EQ(accumulation.ResetCount(ResetCause::Settings), 1u);
    for (const float value : variance.values) EXPECT_EQ(value, 0.0f);
}

TEST_F(AccumulateTest, Accumulate_CulledAddsNothing) {
    Add(Sample(0));
    harness.Run([&](PassHarness& h) {
        const TextureId texture = h.Texture("sample", kExtent, Format::Rgba32Float, Sample(1));
        std::ignore = passes::Accumulate(h.Graph(), texture, accumulation);
        return texture;  // another view is shown
    });
    EXPECT_EQ(accumulation.SampleCount(), 1u);
    EXPECT_NE(harness.Plan().find("culled"), std::string::npos);
}

}  // namespace raygraph::testing::accumulate_test

// Accumulate of several samples at once: the sums of those one after the other.
namespace raygraph::testing::accumulate_rows_test {

using passes::Accumulation;

namespace {

constexpr uint32_t kWidth = 2, kTiles = 2;

class AccumulateRows : public VulkanTest {
  protected:
    // A row of texels of both signs, and of very different size.
    static std::vector<float> RowOf(uint32_t tile, uint32_t number) {
        std::vector<float> values(4 * kWidth);
        for (uint32_t i = 0; i < values.size(); ++i)
            values[i] =
                (float(((number + 10 * tile) * 7 + i * 3) % 11) - 5.0f) * (number % 2 == 0 ? 1e-9f : 1e7f);
        return values;
    }
    // Adds samples to a picture of two tiles of a row each; its mean, and then its variance.
    std::vector<float> Add(Accumulation& into, uint32_t first, uint32_t count) {
        std::vector<float> texels;
        for (uint32_t tile = 0; tile < kTiles; ++tile)
            for (uint32_t n = first; n < first + count; ++n)
                std::ranges::copy(RowOf(tile, n), std::back_inserter(texels));
        std::vector<float> both =
            harness
                .Run([&](PassHarness& h) {
                    const TextureId samples =
                        h.Texture("samples", {kWidth, kTiles * count}, Format::Rgba32Float, texels);
                    return passes::Accumulate(h.Graph(), samples, {.count = count, .height = 1}, into, true)
                        .mean;
                })
                .values;
        const Texels variance = harness.Run([&](PassHarness& h) {
            return passes::Resolve(h.Graph(), into, {kWidth, kTiles}, true).variance;
        });
        std::ranges::copy(variance.values, std::back_inserter(both));
        return both;
    }
    std::string ErrorOf(Extent2D extent, const passes::SampleRows& rows) {
        return ErrorTextOf([&] {
            harness.Run([&](PassHarness& h) {
                const TextureId samples =
                    h.Texture("samples", extent, Format::Rgba32Float,
                              std::vector<float>(size_t{4} * extent.width * extent.height));
                Accumulation accumulation("refused");
                return passes::Accumulate(h.Graph(), samples, rows, accumulation).mean;
            });
        });
    }

    PassHarness harness{Device()};
};

}  // namespace

TEST_F(AccumulateRows, SeveralSamplesAtOnceAreThoseOneAfterTheOther) {
    constexpr uint32_t kCount = 5;
    Accumulation single("single"), several("several");
    std::vector<float> expected;
    for (uint32_t n = 0; n < kCount; ++n) expected = Add(single, n, 1);
    Add(several, 0, 1);
    EXPECT_EQ(Add(several, 1, kCount - 1), expected);
    EXPECT_EQ(several.SampleCount(), kCount);
}

TEST_F(AccumulateRows, SeveralSamplesMayBeTheFirst) {
    Accumulation single("single"), several("several");
    Add(single, 0, 1);
    const std::vector<float> expected = Add(single, 1, 1);
    several.Reset(passes::ResetCause::Start);
    EXPECT_EQ(Add(several, 0, 2), expected);
}

TEST_F(AccumulateRows, RefusesATextureThatTheSamplesDoNotFill) {
    EXPECT_EQ(ErrorOf({2, 3}, {.count = 2, .height = 1}),
              "accumulation \"refused\": 2 samples of 1 rows in a texture of 3 rows, which is no multiple of "
              "that");
    EXPECT_NE(ErrorOf({2, 3}, {.count = 0}), "accepted");
    EXPECT_NE(ErrorOf({2, 3}, {.count = 4}), "accepted");
}

}  // namespace raygraph::testing::accumulate_rows_test

// Tonemap alone, against the same text compiled for the CPU.
namespace raygraph::testing::tonemap_test {

namespace {

class TonemapTest : public VulkanTest {
  protected:
    PassHarness harness{Device()};
};

constexpr uint32_t kWidth = 64;
// Vulkan lets a device store either of the two nearest codes of 8 bits ("Conversion From Floating-Point to
// Normalized Fixed-Point"); the rest is for its powers and logarithms.
constexpr float kCode = 1.0f / 255.0f + 1e-4f;

// Colors from far below to far above the displayable range, of every hue.
std::vector<float> Colors() {
    std::vector<float> values;
    for (uint32_t i = 0; i < kWidth; ++i) {
        const float luminance = std::exp2(-12.0f + 20.0f * float(i) / kWidth);
        for (uint32_t channel = 0; channel < 3; ++channel)
            values.push_back(luminance * (0.2f + 0.8f * float((i * (channel + 3)) % 7) / 6.0f));
        values.push_back(float(i % 5) / 4.0f);
    }
    return values;
}

}  // namespace

TEST_F(TonemapTest, Tonemap_EveryOperatorIsTheCpusWithinOneCode) {
    const std::vector<float> colors = Colors();
    for (const auto op : {TonemapOperator::Linear, TonemapOperator::Srgb, TonemapOperator::Reinhard,
                          TonemapOperator::Aces, TonemapOperator::AgX, TonemapOperator::Neutral})
        for (const float exposure : {0.0f, -1.5f, 2.0f}) {
            const Texels shown = harness.Run([&](PassHarness& h) {
                const TextureId radiance = h.Texture("radiance", {kWidth, 1}, Format::Rgba32Float, colors);
                return passes::Tonemap(h.Graph(), radiance, {exposure, op});
            });
            for (uint32_t i = 0; i < kWidth; ++i) {
                const shading::vec3 expected =
                    shading::Tonemap(shading::vec3(colors[4 * i], colors[4 * i + 1], colors[4 * i + 2]),
                                     exposure, uint32_t(op));
                for (uint32_t channel = 0; channel < 3; ++channel)
                    EXPECT_NEAR(shown.At(i, 0)[channel], expected[int(channel)], kCode)
                        << "operator " << int(op) << ", exposure " << exposure << ", color " << i;
                EXPECT_NEAR(shown.At(i, 0)[3], colors[4 * i + 3], kCode);
            }
        }
}

TEST_F(TonemapTest, Tonemap_UnassociatedColorIsThatOfWhatAlphaCovers) {
    const std::vector<float> radiance = {0.4f, 0.2f,  0.1f,   1.0f,  0.2f, 0.1f, 0.05f, 0.5f,
                                         0.1f, 0.05f, 0.025f, 0.25f, 0.0f, 0.0f, 0.0f,  0.0f};
    const Texels shown = harness.Run([&](PassHarness& h) {
        const TextureId texture = h.Texture("radiance", {4, 1}, Format::Rgba32Float, radiance);
        return passes::Tonemap(h.Graph(), texture,
                               {.tonemapOperator = TonemapOperator::Linear, .isUnassociated = true});
    });
    for (uint32_t x = 0; x < 4; ++x) {
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(shown.At(x, 0)[c], x < 3 ? radiance[static_cast<size_t>(c)] : 0.0f, kCode) << x;
        EXPECT_NEAR(shown.At(x, 0)[3], radiance[4 * x + 3], kCode);
    }
}

// A lamp that covers a part of a pixel, beside a ground that it lights: alpha is below what the lamp covers.
TEST_F(TonemapTest, Tonemap_UnassociatedColorKeepsItsLight) {
    const std::vector<float> radiance = {3.0f, 0.5f,  0.0f, -40.0f, 0.2f, 0.1f,
                                         0.0f, -1.0f, 0.2f, 0.1f,   0.0f, 0.01f};
    const Texels shown = harness.Run([&](PassHarness& h) {
        const TextureId texture = h.Texture("radiance", {3, 1}, Format::Rgba32Float, radiance);
        return passes::Tonemap(h.Graph(), texture,
                               {.tonemapOperator = TonemapOperator::Srgb, .isUnassociated = true});
    });
    for (uint32_t x = 0; x < 3; ++x)
        for (uint32_t c = 0; c < 3; ++c) {
            const double light = shading::SrgbDecode(shown.At(x, 0)[c]) * shown.At(x, 0)[3];
            EXPECT_NEAR(light, std::min(radiance[4 * x + c], 1.0f), 0.01) << x << ", " << c;
        }
}

TEST_F(TonemapTest, Tonemap_WhiteBalanceIsBeforeExposureAndCurve) {
    const std::vector<float> colors = Colors();
    // Columns
    const glm::mat3 balance(glm::vec3(0.5f, 0.1f, 0.0f), glm::vec3(0.0f, 1.0f, 0.2f),
                            glm::vec3(0.25f, -0.1f, 2.0f));
    const Texels shown = harness.Run([&](PassHarness& h) {
        const TextureId texture = h.Texture("radiance", {kWidth, 1}, Format::Rgba32Float, colors);
        return passes::Tonemap(h.Graph(), texture,
                               {.exposureEv = -1.0f,
                                .tonemapOperator = TonemapOperator::Reinhard,
                                .isOpaque = true,
                                .whiteBalance = balance});
    });
    for (uint32_t i = 0; i < kWidth; ++i) {
        const glm::vec3 balanced = balance * glm::vec3(colors[4 * i], colors[4 * i + 1], colors[4 * i + 2]);
        const shading::vec3 expected = shading::Tonemap(shading::vec3(balanced.x, balanced.y, balanced.z),
                                                        -1.0f, uint32_t(TonemapOperator::Reinhard));
        for (uint32_t c = 0; c < 3; ++c)
            EXPECT_NEAR(shown.At(i, 0)[c], expected[int(c)], kCode) << "color " << i;
        EXPECT_EQ(shown.At(i, 0)[3], 1.0f);
    }
}

TEST_F(TonemapTest, Tonemap_NanAndNegativeAreBlack) {
    const Texels shown = harness.Run([&](PassHarness& h) {
        const TextureId radiance = h.Texture("radiance", {2, 1}, Format::Rgba32Float,
                                             {NAN, -1.0f, 0.0f, 1.0f, 1e30f, INFINITY, 1.0f, 1.0f});
        return passes::Tonemap(h.Graph(), radiance, {0.0f, TonemapOperator::Srgb});
    });
    for (uint32_t channel = 0; channel < 3; ++channel) EXPECT_EQ(shown.At(0, 0)[channel], 0.0f);
    for (uint32_t channel = 0; channel < 3; ++channel) EXPECT_EQ(shown.At(1, 0)[channel], 1.0f);
}

TEST_F(TonemapTest, Tonemap_EveryOptionChangesColorOrAlphaAndNotTheOther) {
    using passes::TonemapSettings;
    struct Row {
        const char* name;
        void (*change)(TonemapSettings&);
        bool isOfColor = true;
    };
    const Row kRows[] = {
        {"exposure", [](TonemapSettings& s) { s.exposureEv = 1.0f; }},
        {"linear", [](TonemapSettings& s) { s.tonemapOperator = TonemapOperator::Linear; }},
        {"srgb", [](TonemapSettings& s) { s.tonemapOperator = TonemapOperator::Srgb; }},
        {"reinhard", [](TonemapSettings& s) { s.tonemapOperator = TonemapOperator::Reinhard; }},
        {"aces", [](TonemapSettings& s) { s.tonemapOperator = TonemapOperator::Aces; }},
        {"agx", [](TonemapSettings& s) { s.tonemapOperator = TonemapOperator::AgX; }},
        {"unassociated", [](TonemapSettings& s) { s.isUnassociated = true; }},
        {"white balance", [](TonemapSettings& s) { s.whiteBalance[1].x = 0.5f; }},
        {"opaque", [](TonemapSettings& s) { s.isOpaque = true; }, false},
    };
    const std::vector<float> colors = Colors();
    struct Shown {
        std::vector<float> color, alpha;
    };
    const auto show = [&](const TonemapSettings& settings) {
        const Texels texels = harness.Run([&](PassHarness& h) {
            return passes::Tonemap(h.Graph(), h.Texture("radiance", {kWidth, 1}, Format::Rgba32Float, colors),
                                   settings);
        });
        Shown shown;
        for (uint32_t i = 0; i < 4 * kWidth; ++i)
            (i % 4 == 3 ? shown.alpha : shown.color).push_back(texels.values[i]);
        return shown;
    };
    auto rows = OptionRowsOf<TonemapSettings>([](TonemapSettings& s) {
        auto& [exposure, tonemapOperator, isOpaque, isUnassociated, whiteBalance] = s;
        return std::tie(exposure, tonemapOperator, isOpaque, isUnassociated, whiteBalance);
    });
    const Shown before = show({});
    std::map<std::vector<float>, std::string> pictures{{before.color, "the defaults"}};
    for (const Row& row : kRows) {
        TonemapSettings settings;
        row.change(settings);
        rows.Add(row.name, {}, settings);
        const Shown after = show(settings);
        if (row.isOfColor) {
            const auto [found, isNew] = pictures.emplace(after.color, row.name);
            EXPECT_TRUE(isNew) << row.name << " looks like " << found->second;
            for (size_t i = 0; i < kWidth; ++i)  // bright colors have more, so that they keep their light
                EXPECT_TRUE(after.alpha[i] == before.alpha[i] ||
                            (settings.isUnassociated && after.alpha[i] > before.alpha[i]))
                    << row.name << ", " << i;
        } else {
            EXPECT_EQ(after.alpha, std::vector<float>(kWidth, 1.0f)) << row.name;
            EXPECT_EQ(after.color, before.color) << row.name;
        }
    }
    rows.ExpectComplete();
}

}  // namespace raygraph::testing::tonemap_test

// The white balance against published chromaticities, and in closed form.
namespace raygraph::passes::white_balance_test {
namespace {

// CIE 15: illuminant A, and daylight of 5000 and 7500 K nominally.
constexpr glm::dvec2 kA(0.44758, 0.40745), kD50(0.34567, 0.35851), kD75(0.29903, 0.31488);

void ExpectNear(const glm::dvec2& a, const glm::dvec2& b, double tolerance) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
}

TEST(WhiteBalance, WhitePointsAreThoseOfTheStandardIlluminants) {
    ExpectNear(WhitePointAt(2856.0), kA, 4e-4);
    ExpectNear(WhitePointAt(5003.0), kD50,
               2e-4);  // the constants of radiation have changed since D50 was named
    ExpectNear(WhitePointAt(7504.0), kD75, 2e-4);
    EXPECT_EQ(WhitePointAt(6500.0), glm::dvec2(kDisplayWhite[0], kDisplayWhite[1]));
    ExpectNear(WhitePointAt(6504.0), WhitePointAt(6500.0), 2e-4);
    // Black bodies at 2000 and 3500 K (Kang et al. 2002, and Planck's law)
    ExpectNear(WhitePointAt(2000.0), {0.5267, 0.4133}, 5e-4);
    ExpectNear(WhitePointAt(3500.0), {0.4053, 0.3907}, 5e-4);
    for (const double kelvin : {999.0, 25001.0, -1.0})
        EXPECT_THROW(std::ignore = WhitePointAt(kelvin), Error) << kelvin;
}

TEST(WhiteBalance, TheDisplaysWhiteChangesNothing) {
    EXPECT_EQ(WhiteBalance(WhitePointAt(6500.0)), glm::mat3(1.0f));
    ExpectNear(ChromaticityOf(glm::dvec3(1.0)), WhitePointAt(6500.0), 1e-12);
    const glm::mat3 almost = WhiteBalance(ChromaticityOf(glm::dvec3(0.3)));
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) EXPECT_NEAR(almost[c][r], c == r ? 1.0f : 0.0f, 1e-6f);
}

// Linear Rec. 709 of a chromaticity, by the inverse of IEC 61966-2-1's matrix, of luminance 1.
glm::dvec3 ColorOf(const glm::dvec2& xy) {
    const double x = xy.x / xy.y, z = (1.0 - xy.x - xy.y) / xy.y;
    return {3.2406 * x - 1.5372 - 0.4986 * z, -0.9689 * x + 1.8758 + 0.0415 * z,
            0.0557 * x - 0.2040 + 1.0570 * z};
}

TEST(WhiteBalance, TheWhiteOfALightBecomesNeutralOfTheSameLuminance) {
    for (const glm::dvec2& white : {kA, kD50, kD75, glm::dvec2(0.33, 0.36)}) {
        const glm::dvec3 shown = glm::dmat3(WhiteBalance(white)) * ColorOf(white);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[c], 1.0, 2e-3);
    }
    // Illuminant A is given by its temperature, to the precision of the locus
    const glm::dvec3 shown = glm::dmat3(WhiteBalance(WhitePointAt(2856.0))) * ColorOf(kA);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[c], 1.0, 1e-2);
}

// Bradford's matrix from D50 to D65 as it is published (B. Lindbloom, from ASTM E308's whites).
TEST(WhiteBalance, IsBradfordsAdaptation) {
    const glm::dmat3 published = glm::transpose(glm::dmat3{{0.9555766, -0.0230393, 0.0631636},
                                                           {-0.0282895, 1.0099416, 0.0210077},
                                                           {0.0122982, -0.0204830, 1.3299098}});
    const glm::dmat3 toXyz = glm::transpose(glm::dmat3{{0.4124564, 0.3575761, 0.1804375},
                                                       {0.2126729, 0.7151522, 0.0721750},
                                                       {0.0193339, 0.1191920, 0.9503041}});
    const glm::dvec2 white(0.96422 / (0.96422 + 1.0 + 0.82521), 1.0 / (0.96422 + 1.0 + 0.82521));
    const glm::dmat3 expected = glm::inverse(toXyz) * published * toXyz, made(WhiteBalance(white));
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) EXPECT_NEAR(made[c][r], expected[c][r], 1e-3) << c << " " << r;
}

}  // namespace
}  // namespace raygraph::passes::white_balance_test
