// Accumulate of several samples at once: the sums of those one after the other.
#include <algorithm>
#include <iterator>

#include "passes/accumulate.h"
#include "renderer/graph/pass_harness.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

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
