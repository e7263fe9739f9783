// Tests where the noise of a stored render is said to be, by renders whose numbers are known.
#include "editor/session/explain/noise.h"

#include <gmock/gmock.h>

#include "shaders/core/ramp.glsl"
#include "tests/support/error_of.h"

namespace raygraph::session::noise_test {

namespace {

using ::testing::HasSubstr;

// 3x2 pixels of 16 samples, which are the part at (5, 7) of a picture.
RenderFile KnownRender() {
    RenderFile render;
    render.size = {3, 2};
    render.samples = {{0, 16}};
    render.settings = {{"size", "20x10"}, {"crop", "5,7,3,2"}, {"light-group", "key=lamp*"}};
    const float means[] = {1.0f, 2.0f, 0.0f, 0.5f, 4.0f, 0.25f};
    const float variances[] = {16.0f, 0.0f, 0.0f, 64.0f, 1.6e-5f, 0.0f};
    for (size_t i = 0; i < 6; ++i) {
        for (int c = 0; c < 3; ++c) render.radiance.push_back(means[i]);
        render.radiance.push_back(1.0f);
        render.variance.insert(render.variance.end(), 4, variances[i]);
    }
    // In this order: rest, environment, key
    const float shares[] = {0.25f, 0.0f, 0.75f};
    for (const float share : shares) {
        Texels& group = render.lightGroups.emplace_back(render.radiance);
        for (float& value : group) value *= share;
    }
    // The second pixel is lit by the environment alone
    for (size_t c = 4; c < 7; ++c) {
        render.lightGroups[1][c] = render.radiance[c];
        render.lightGroups[0][c] = render.lightGroups[2][c] = 0.0f;
    }
    return render;
}

glm::ivec3 Texel(const image::Image8& map, size_t pixel) {
    return {map.rgba[4 * pixel], map.rgba[4 * pixel + 1], map.rgba[4 * pixel + 2]};
}

glm::ivec3 Bytes(const glm::vec3& display) {
    return glm::ivec3(glm::round(255.0f * display));
}

}  // namespace

TEST(NoiseOfARender, IsByPixelsShareOfTheVarianceOfMeans) {
    RenderFile render = KnownRender();
    const std::vector<NoisyPixel> noisiest = NoisiestPixels(render, 3);
    ASSERT_EQ(noisiest.size(), 3u);
    EXPECT_EQ(noisiest[0].pixel, glm::uvec2(5, 8)) << "not of the whole picture";
    EXPECT_EQ(noisiest[1].pixel, glm::uvec2(5, 7));
    EXPECT_EQ(noisiest[2].pixel, glm::uvec2(6, 8));
    EXPECT_NEAR(noisiest[0].varianceShare, 0.8, 1e-6);
    EXPECT_NEAR(noisiest[0].relativeError, 4.0, 1e-6) << "sqrt(64 / 16) / .5";
    EXPECT_NEAR(noisiest[1].relativeError, 1.0, 1e-6);

    render.adaptive.emplace().counts = {16, 16, 16, 1024, 16, 16};
    EXPECT_EQ(NoisiestPixels(render, 1)[0].pixel, glm::uvec2(5, 7)) << "samples of a pixel do not count";
    render.variance.assign(render.variance.size(), 0.0f);
    EXPECT_TRUE(NoisiestPixels(render, 3).empty());
    render.variance.clear();
    EXPECT_THAT(testing::ErrorTextOf([&] { NoisiestPixels(render, 3); }, ErrorKind::BadInput),
                HasSubstr("has no variance"));
}

TEST(NoiseOfARender, IsShownByTheLogarithmOfTheRelativeError) {
    const image::Image8 map = NoiseMap(KnownRender());
    ASSERT_EQ(map.rgba.size(), 24u);
    // Relative errors: 1, 0, none of black, 4 (as 1), .00025 (as .001), 0
    const float heights[] = {1.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f};
    for (const size_t pixel : {0u, 1u, 3u, 4u, 5u})
        EXPECT_EQ(Texel(map, pixel), Bytes(shading::SrgbEncode(shading::HeatColor(heights[pixel]))));
    EXPECT_EQ(Texel(map, 2), glm::ivec3(0));
    RenderFile tenth = KnownRender();
    for (float& value : tenth.variance) value *= 0.01f;
    EXPECT_EQ(Texel(NoiseMap(tenth), 0), Bytes(shading::SrgbEncode(shading::HeatColor(2.0f / 3.0f))));
}

TEST(LightGroupsOfARender, AreSharesOfLuminanceAndColors) {
    RenderFile render = KnownRender();
    const std::vector<LightGroupShare> pixel = LightGroupShares(render, glm::uvec2(5, 7));
    ASSERT_EQ(pixel.size(), 2u) << "a group without light is listed";
    EXPECT_EQ(pixel[0].name, "key");
    EXPECT_NEAR(pixel[0].share, 0.75, 1e-6);
    EXPECT_EQ(pixel[1].name, "rest");
    const std::vector<LightGroupShare> all = LightGroupShares(render);
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[1].name, "environment");
    EXPECT_NEAR(all[1].share, 2.0 / 7.75, 1e-6);
    const image::Image8 map = LightGroupMap(render);
    EXPECT_EQ(Texel(map, 1), Bytes(shading::IdColor(1)));
    EXPECT_EQ(Texel(map, 2), glm::ivec3(0));
    EXPECT_EQ(Texel(map, 0), Bytes(0.25f * shading::IdColor(0) + 0.75f * shading::IdColor(2)));
    EXPECT_THAT(testing::ErrorTextOf([&] { LightGroupShares(render, glm::uvec2(4, 7)); }),
                HasSubstr("pixel 4,7 was not rendered"));
    render.lightGroups.clear();
    EXPECT_THAT(testing::ErrorTextOf([&] { LightGroupMap(render); }, ErrorKind::BadInput),
                HasSubstr("--light-group"));
}

}  // namespace raygraph::session::noise_test
