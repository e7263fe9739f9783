#include "core/color.glsl"
#include "core/ramp.glsl"

#include <gtest/gtest.h>

#include <algorithm>

namespace raygraph::shading::color_test {
namespace {

TEST(Color, SrgbMeetsPublishedPairs) {
    // Code value / 255 against linear light, IEC 61966-2-1.
    EXPECT_EQ(SrgbEncode(0.0f), 0.0f);
    EXPECT_NEAR(SrgbEncode(1.0f), 1.0f, 1e-6f);
    EXPECT_NEAR(SrgbEncode(0.5f), 0.7353570f, 1e-6f);
    EXPECT_NEAR(SrgbEncode(0.18f), 0.4613561f, 1e-6f);
    EXPECT_NEAR(SrgbDecode(0.5f), 0.2140411f, 1e-6f);
    EXPECT_NEAR(SrgbDecode(1.0f / 255.0f), 3.035270e-4f, 1e-9f);
    EXPECT_NEAR(SrgbDecode(186.0f / 255.0f), 0.4910209f, 1e-6f);
}

TEST(Color, IdsAreDistinctColorsOfTwoBrightnesses) {
    std::vector<vec3> colors;
    for (uint id = 0; id < 64; ++id) {
        const vec3 color = IdColor(id);
        EXPECT_FLOAT_EQ(std::max({color.x, color.y, color.z}), id % 2 == 0 ? 0.95f : 0.7f) << id;
        EXPECT_GE(std::min({color.x, color.y, color.z}), 0.17f) << id;
        for (size_t other = 0; other < colors.size(); ++other)
            EXPECT_GT(length(colors[other] - color), other + 1 == id ? 0.2f : 0.004f)
                << other << " and " << id;
        colors.push_back(color);
    }
}

TEST(Color, SrgbIsMonotonicAndInvertible) {
    float previous = -1.0f;
    for (int i = 0; i <= 100'000; ++i) {
        const float x = static_cast<float>(i) / 100'000.0f;
        const float encoded = SrgbEncode(x);
        // The standard's two pieces meet to within 3e-8 in its rounded constants.
        ASSERT_GT(encoded, previous - 1e-7f) << x;
        ASSERT_NEAR(SrgbDecode(encoded), x, 2e-6f) << x;
        previous = encoded;
    }
}

TEST(Color, LuminanceOfWhiteIsOne) {
    EXPECT_NEAR(Luminance(vec3(1.0f)), 1.0f, 1e-6f);
    EXPECT_EQ(Luminance(vec3(0.0f, 1.0f, 0.0f)), 0.7152f);
}

}  // namespace
}  // namespace raygraph::shading::color_test
