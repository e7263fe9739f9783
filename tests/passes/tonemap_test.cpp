// Tonemap alone, against the same text compiled for the CPU.
#include "passes/tonemap.h"

#include <cmath>
#include <map>
#include <string>

#include "core/tonemap.glsl"
#include "renderer/graph/pass_harness.h"
#include "tests/support/option_rows.h"
#include "tests/support/vulkan_test.h"

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
            EXPECT_EQ(after.alpha, before.alpha) << row.name;
        } else {
            EXPECT_EQ(after.alpha, std::vector<float>(kWidth, 1.0f)) << row.name;
            EXPECT_EQ(after.color, before.color) << row.name;
        }
    }
    rows.ExpectComplete();
}

}  // namespace raygraph::testing::tonemap_test
