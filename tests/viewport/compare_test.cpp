// The passes that compare two pictures, with hand-made texels; and the numbers of a viewport.
#include "passes/compare.h"

#include <limits>
#include <string>

#include "base/error.h"
#include "passes/overlay.h"
#include "renderer/graph/pass_harness.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::compare_test {

namespace {

class Compare : public VulkanTest {
  protected:
    PassHarness harness{Device()};
};

// Gray values 0 ... 1 as rgba, one a texel.
std::vector<float> Grays(const std::vector<float>& values) {
    std::vector<float> texels;
    for (const float value : values) texels.insert(texels.end(), {value, value, value, 1.0f});
    return texels;
}

std::vector<float> Ramp(size_t count, float from, float step) {
    std::vector<float> values(count);
    for (size_t i = 0; i < count; ++i) values[i] = from + step * float(i);
    return values;
}

}  // namespace

TEST_F(Compare, Wipe_ShowsOnePictureOnEitherSideOfTheLine) {
    const auto wiped = [&](float position) {
        const Texels texels = harness.Run([&](PassHarness& h) {
            return passes::Wipe(h.Graph(), h.Texture("left", {8, 2}, Format::Rgba8Unorm, {0, 0, 0, 1}),
                                h.Texture("right", {8, 2}, Format::Rgba8Unorm, {0, 0, 1, 1}), position);
        });
        std::string row;
        for (uint32_t x = 0; x < 8; ++x) {
            const auto texel = texels.At(x, 1);
            row += texel[0] > 0.5f ? '|' : texel[2] > 0.5f ? 'R' : 'L';
        }
        return row;
    };
    EXPECT_EQ(wiped(0.5f), "LLLL|RRR");
    EXPECT_EQ(wiped(0.25f), "LL|RRRRR");
    EXPECT_EQ(wiped(0.0f), "RRRRRRRR");
    EXPECT_EQ(wiped(1.0f), "LLLLLLLL");
    EXPECT_EQ(wiped(-3.0f), "RRRRRRRR");
    EXPECT_EQ(wiped(std::numeric_limits<float>::quiet_NaN()), "RRRRRRRR");
}

TEST_F(Compare, SideBySide_ShowsAllOfBothAtHalfTheSize) {
    const std::vector<float> left = Grays(Ramp(16, 0.0f, 4.0f / 255.0f));
    const Texels texels = harness.Run([&](PassHarness& h) {
        return passes::SideBySide(h.Graph(), h.Texture("left", {4, 4}, Format::Rgba8Unorm, left),
                                  h.Texture("right", {4, 4}, Format::Rgba8Unorm, {1, 1, 1, 1}));
    });
    // Means of 2 x 2: rows 0 and 1 of the left picture in row 1
    EXPECT_NEAR(texels.At(0, 1)[0] * 255.0f, (0 + 4 + 16 + 20) / 4.0f, 0.51f);
    EXPECT_NEAR(texels.At(1, 2)[0] * 255.0f, (40 + 44 + 56 + 60) / 4.0f, 0.51f);
    EXPECT_EQ(texels.At(2, 1)[0], 1.0f);
    EXPECT_EQ(texels.At(3, 2)[0], 1.0f);
    EXPECT_LT(texels.At(2, 0)[0], 0.2f);
    EXPECT_LT(texels.At(0, 3)[0], 0.2f);
}

TEST_F(Compare, RelativeErrorAndDifference_AreWhatTheirFormulasSay) {
    const std::vector<float> reference{1, 1, 1, 1, 0, 0, 0, 1, 0, 2, 0, 1};
    const std::vector<float> test{1.5f, 1.5f, 1.5f, 1, 0.02f, 0.02f, 0.02f, 1, 0, 1, 0, 1};
    const auto pictures = [&](PassHarness& h) {
        return std::pair(h.Texture("reference", {3, 1}, Format::Rgba32Float, reference),
                         h.Texture("test", {3, 1}, Format::Rgba32Float, test));
    };
    const Texels error = harness.Run([&](PassHarness& h) {
        const auto [a, b] = pictures(h);
        return passes::RelativeError(h.Graph(), a, b, 0.01f);
    });
    EXPECT_NEAR(error.At(0, 0)[0], 0.5f, 1e-5f);
    EXPECT_NEAR(error.At(1, 0)[0], 2.0f, 1e-5f);
    EXPECT_NEAR(error.At(2, 0)[0], 0.5f, 1e-5f);
    const Texels difference = harness.Run([&](PassHarness& h) {
        const auto [a, b] = pictures(h);
        return passes::Difference(h.Graph(), a, b).difference;
    });
    EXPECT_EQ(difference.At(0, 0)[0], 0.5f);
    EXPECT_EQ(difference.At(2, 0)[1], 1.0f);
    EXPECT_EQ(difference.At(2, 0)[0], 0.0f);
    const Texels luminance = harness.Run([&](PassHarness& h) {
        const auto [a, b] = pictures(h);
        return passes::Difference(h.Graph(), a, b).luminance;
    });
    EXPECT_NEAR(luminance.At(2, 0)[0], 0.7152f, 1e-5f);
}

TEST_F(Compare, NumbersOfAMap_AreItsMeanAndItsGreatest) {
    const Extent2D extent{37, 21};
    std::vector<float> values = Ramp(size_t{37} * 21, 0.0f, 0.001f);
    std::swap(values[5], values.back());
    Renderer& renderer = harness.Graph();
    Readback groups;
    harness.Run([&](PassHarness& h) {
        const TextureId map = h.Texture("map", extent, Format::R32Float, values);
        groups = renderer.ReadBack(passes::SumGroups(renderer, map));
        EXPECT_THROW(passes::NumbersOf(groups, extent), Error);
        return map;
    });
    const passes::MapNumbers numbers = passes::NumbersOf(groups, extent);
    EXPECT_NEAR(numbers.mean, 0.5 * 0.001 * (37 * 21 - 1), 1e-5);
    EXPECT_EQ(numbers.maximum, values[5]);
    EXPECT_THROW(passes::NumbersOf(groups, {64, 64}), Error);
}

TEST_F(Compare, Heat_IsLighterTheGreaterTheValue) {
    std::vector<float> values = Ramp(32, 0.0f, 1.0f / 31.0f);
    values.push_back(std::numeric_limits<float>::quiet_NaN());
    const Texels texels = harness.Run([&](PassHarness& h) {
        return passes::Heat(h.Graph(), h.Texture("map", {33, 1}, Format::R32Float, values), 1.0f);
    });
    const auto lightness = [&](uint32_t x) {
        const auto c = texels.At(x, 0);
        return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
    };
    for (uint32_t x = 1; x < 32; ++x) EXPECT_GT(lightness(x), lightness(x - 1)) << x;
    EXPECT_EQ(lightness(32), lightness(0));
    EXPECT_GT(lightness(31), 0.8f);
}

TEST_F(Compare, Overlay_ShowsWhatIsDoneOverWhatIsCoarse) {
    passes::TileCursor cursor;
    cursor.Advance({4, 4}, {0, 0, 4, 1});
    cursor.Advance({4, 4}, {0, 1, 2, 2});
    const Texels texels = harness.Run([&](PassHarness& h) {
        return passes::Overlay(h.Graph(), h.Texture("coarse", {1, 1}, Format::Rgba32Float, {0.25f, 0, 0, 1}),
                               h.Texture("fine", {4, 4}, Format::Rgba32Float, {8, 0, 0, 1}), cursor);
    });
    std::string rows;
    for (uint32_t y = 0; y < 4; ++y)
        for (uint32_t x = 0; x < 4; ++x) rows += texels.At(x, y)[0] == 8.0f ? 'F' : '.';
    EXPECT_EQ(rows, "FFFFFF..FF......");
    // Linear between the centers of coarse pixels
    const Texels scaled = harness.Run([&](PassHarness& h) {
        return passes::Upscale(
            h.Graph(), h.Texture("coarse", {2, 1}, Format::Rgba32Float, {0, 0, 0, 1, 8, 0, 0, 1}), {8, 3});
    });
    const float expected[8] = {0, 0, 1, 3, 5, 7, 8, 8};
    for (uint32_t x = 0; x < 8; ++x) EXPECT_NEAR(scaled.At(x, 2)[0], expected[x], 1e-5f);
}

TEST_F(Compare, Viewport_GivesTheNumbersOfWhatItShows) {
    ViewedScene viewed(Device());
    EXPECT_FALSE(viewed.viewport.Numbers().has_value());
    double means[3] = {};
    int i = 0;
    for (const View view : {View::Difference, View::RelativeError, View::Flip}) {
        viewed.viewport.SetView(view);
        viewed.RenderFrames(2);
        Device().WaitIdle();
        const std::optional<viewport::CompareNumbers> numbers = viewed.viewport.Numbers();
        ASSERT_TRUE(numbers.has_value());
        EXPECT_EQ(numbers->view, view);
        EXPECT_EQ(numbers->pathTracedSamples, viewed.Samples());
        EXPECT_EQ(numbers->rasterSamples, viewed.viewport.Progress().rasterSamples);
        EXPECT_GE(numbers->numbers.maximum, numbers->numbers.mean);
        means[i++] = numbers->numbers.mean;
    }
    // Without what is scattered more than once, the raster view is darker, but it is not black
    EXPECT_GT(means[1], 0.02);
    EXPECT_LT(means[1], 1.0);
    EXPECT_GT(means[2], 0.01);
    EXPECT_LT(means[2], 0.95);
}

TEST_F(Compare, Viewport_MakesAMapAnewOnlyWhenItsPicturesChange) {
    ViewedScene viewed(Device());
    viewed.viewport.SetBudget({.maxSamples = 2, .maxRasterSamples = 2});
    viewed.viewport.SetView(View::Flip);
    const auto isMade = [&] {
        viewed.RenderFrames(1);
        return viewed.renderer.DescribePlan().find("FlipColumns") != std::string::npos;
    };
    EXPECT_TRUE(isMade());
    EXPECT_TRUE(isMade());
    EXPECT_FALSE(isMade());
    viewport::ShowSettings show = viewed.viewport.Show();
    show.tonemap.exposureEv = 1.0f;
    viewed.viewport.SetShow(show);
    EXPECT_TRUE(isMade());
    EXPECT_FALSE(isMade());
    // The map is made anew for other pictures with the same number of samples
    viewed.viewport.SetBudget({.maxSamples = 1, .maxRasterSamples = 1, .settleMs = 0.0});
    for (const float x : {0.1f, 0.2f}) {
        scene::CameraView camera = InsideBoxes();
        camera.eye.x += x;
        viewed.viewport.SetCamera(camera);
        EXPECT_TRUE(isMade());
        isMade();  // how fine the new picture is becomes known in the next frame
        EXPECT_FALSE(isMade());
    }
}

}  // namespace raygraph::testing::compare_test
