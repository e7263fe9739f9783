// Accumulate alone: hand-made samples in, mean and variance out.
#include "passes/accumulate.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include "renderer/graph/pass_harness.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

using passes::Accumulation;
using passes::ResetCause;

namespace {

constexpr Extent2D kExtent{2, 1};

class AccumulateTest : public VulkanTest {
  protected:
    // One frame: takes a sample of two texels and returns the mean, or the variance.
    Texels Add(const std::vector<float>& sample, bool wantsVariance = false) {
        return harness.Run([&](PassHarness& h) {
            const TextureId texture = h.Texture("sample", kExtent, Format::Rgba32Float, sample);
            const passes::AccumulatedIds ids =
                passes::Accumulate(h.Graph(), texture, accumulation, wantsVariance);
            return wantsVariance ? ids.variance : ids.mean;
        });
    }
    // A sample that differs by texel, channel and number.
    static std::vector<float> Sample(uint32_t number) {
        std::vector<float> values(8);
        for (uint32_t i = 0; i < 8; i++) values[i] = float((number * 7 + i * 3) % 11) * (0.5f + float(i));
        return values;
    }

    PassHarness harness{Device()};
    Accumulation accumulation{"image"};
};

}  // namespace

TEST_F(AccumulateTest, Accumulate_KeepsMeanAndUnbiasedVariance) {
    constexpr uint32_t kCount = 9;
    Texels mean, variance;
    for (uint32_t n = 0; n < kCount; n++) variance = Add(Sample(n), true);
    ASSERT_EQ(accumulation.SampleCount(), kCount);
    mean = Add(Sample(kCount));
    for (uint32_t i = 0; i < 8; i++) {
        double sum = 0.0, squares = 0.0;
        for (uint32_t n = 0; n < kCount; n++) sum += Sample(n)[i];
        for (uint32_t n = 0; n < kCount; n++) squares += std::pow(Sample(n)[i] - sum / kCount, 2);
        EXPECT_NEAR(variance.values[i], squares / (kCount - 1), 1e-5 * squares);
        EXPECT_NEAR(mean.values[i], (sum + Sample(kCount)[i]) / (kCount + 1), 1e-4);
    }
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

TEST_F(AccumulateTest, Accumulate_PoisonedPixelStaysOnePixel) {
    Add({1, 1, 1, 1, 2, 2, 2, 2});
    Add({NAN, 1, INFINITY, 1, 4, 4, 4, 4});
    const Texels mean = Add({1, 1, 1, 1, 6, 6, 6, 6});
    EXPECT_TRUE(std::isnan(mean.At(0, 0)[0]));
    EXPECT_FALSE(std::isfinite(mean.At(0, 0)[2]));
    EXPECT_EQ(mean.At(0, 0)[1], 1.0f);
    for (const float value : mean.At(1, 0)) EXPECT_EQ(value, 4.0f);
}

TEST_F(AccumulateTest, Restore_ContinuesBitForBit) {
    Texels mean, variance;
    for (uint32_t n = 0; n < 5; n++) {
        mean = Add(Sample(n), false);
        accumulation.Reset(ResetCause::Settings);
        for (uint32_t k = 0; k <= n; k++) variance = Add(Sample(k), true);
    }
    // `variance` has the state after five samples; the mean of the same accumulation is read beside it
    mean = harness.Run([&](PassHarness& h) {
        return h.Graph().Persist(accumulation.Name() + ".mean", {kExtent, Format::Rgba32Float});
    });

    PassHarness other(Device());
    Accumulation continued("image");
    other.Run([&](PassHarness& h) {
        passes::Restore(h.Graph(), continued, kExtent, 5, mean.values, variance.values);
        return h.Texture("nothing", {1, 1}, Format::R32Float, {0.0f});
    });
    EXPECT_EQ(continued.SampleCount(), 5u);
    const auto next = [&](PassHarness& h, Accumulation& a, bool wantsVariance) {
        const TextureId texture = h.Texture("sample", kExtent, Format::Rgba32Float, Sample(5));
        const passes::AccumulatedIds ids = passes::Accumulate(h.Graph(), texture, a, true);
        return wantsVariance ? ids.variance : ids.mean;
    };
    const Texels expected = harness.Run([&](PassHarness& h) { return next(h, accumulation, true); });
    const Texels actual = other.Run([&](PassHarness& h) { return next(h, continued, true); });
    EXPECT_EQ(actual.values, expected.values);
    EXPECT_EQ(continued.SampleCount(), 6u);
}

TEST_F(AccumulateTest, Restore_RefusesStateOfAnotherExtent) {
    const std::vector<float> tooFew(4);
    EXPECT_THROW(harness.Run([&](PassHarness& h) {
        passes::Restore(h.Graph(), accumulation, kExtent, 5, tooFew, {});
        return h.Texture("nothing", {1, 1}, Format::R32Float, {0.0f});
    }),
                 Error);
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
    for (uint32_t n = 0; n < 3; n++) Add(Sample(n));
    const Texels variance = Add(Sample(3), true);
    EXPECT_EQ(accumulation.SampleCount(), 1u) << "three samples have no variance: start anew";
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

}  // namespace raygraph::testing
