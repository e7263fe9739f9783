// Tonemap alone, against the same text compiled for the CPU.
#include "passes/tonemap.h"

#include <cmath>

#include "core/tonemap.glsl"
#include "renderer/graph/pass_harness.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

namespace {

class TonemapTest : public VulkanTest {
  protected:
    PassHarness harness{Device()};
};

constexpr uint32_t kWidth = 64;
// Vulkan lets a device store either of the two nearest codes of 8 bits ("Conversion From Floating-Point to
// Normalized Fixed-Point"); the rest is for its powers and logarithms.
constexpr float kCode = 1.0f / 255.0f + 1e-4f;

// Colours from far below to far above the displayable range, of every hue.
std::vector<float> Colors() {
    std::vector<float> values;
    for (uint32_t i = 0; i < kWidth; i++) {
        const float luminance = std::exp2(-12.0f + 20.0f * float(i) / kWidth);
        for (uint32_t channel = 0; channel < 3; channel++)
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
            for (uint32_t i = 0; i < kWidth; i++) {
                const shading::vec3 expected =
                    shading::Tonemap(shading::vec3(colors[4 * i], colors[4 * i + 1], colors[4 * i + 2]),
                                     exposure, uint32_t(op));
                for (uint32_t channel = 0; channel < 3; channel++)
                    EXPECT_NEAR(shown.At(i, 0)[channel], expected[int(channel)], kCode)
                        << "operator " << int(op) << ", exposure " << exposure << ", colour " << i;
                EXPECT_NEAR(shown.At(i, 0)[3], colors[4 * i + 3], kCode);
            }
        }
}

TEST_F(TonemapTest, Tonemap_NanAndNegativeAreBlack) {
    const Texels shown = harness.Run([&](PassHarness& h) {
        const TextureId radiance = h.Texture("radiance", {2, 1}, Format::Rgba32Float,
                                             {NAN, -1.0f, 0.0f, 1.0f, 1e30f, INFINITY, 1.0f, 1.0f});
        return passes::Tonemap(h.Graph(), radiance, {0.0f, TonemapOperator::Srgb});
    });
    for (uint32_t channel = 0; channel < 3; channel++) EXPECT_EQ(shown.At(0, 0)[channel], 0.0f);
    for (uint32_t channel = 0; channel < 3; channel++) EXPECT_EQ(shown.At(1, 0)[channel], 1.0f);
}

}  // namespace raygraph::testing
