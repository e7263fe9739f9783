// Accumulate alone: hand-made samples in, mean and variance out.
#include "passes/accumulate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <tuple>
#include <type_traits>

#include "renderer/graph/pass_harness.h"
#include "tests/support/vulkan_test.h"

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
                    return passes::Kept(h.Graph(), accumulation, kExtent, true).mean;
                }),
                std::move(variance)};
    }
    ExactSums KeptSums() {
        ExactSums sums;
        for (const bool isSquares : {false, true})
            for (size_t k = 0; k < ExactSums::kPlanes; ++k) {
                Readback readback;
                harness.Run([&](PassHarness& h) {
                    const passes::AccumulatedIds ids = passes::Kept(h.Graph(), accumulation, kExtent, true);
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
