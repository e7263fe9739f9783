#include "editor/cli/merge.h"

#include <cmath>
#include <random>

#include "tests/cli/cli_test.h"

namespace raygraph::cli {
namespace {

using test::ExpectError;
using test::MakeRender;

// The values that pixel channel `i` takes in the samples of a range, as mean and unbiased variance.
void SetMoments(RenderFile& render, uint32_t first, uint32_t count) {
    render.samples = {{first, count}};
    for (size_t i = 0; i < render.radiance.size(); i++) {
        double mean = 0.0, squares = 0.0;
        for (uint32_t n = 0; n < count; n++) {
            std::minstd_rand random(1 + first + n);
            random.discard(i + 1);
            const double x = static_cast<double>(random() % 1000003) / 1000003.0;
            const double delta = x - mean;
            mean += delta / (n + 1);
            squares += delta * (x - mean);
        }
        render.radiance[i] = static_cast<float>(mean);
        render.variance[i] = count > 1 ? static_cast<float>(squares / (count - 1)) : 0.0f;
        render.albedo[i] = render.radiance[i];
    }
}

RenderFile Range(uint32_t first, uint32_t count) {
    RenderFile render = MakeRender(first, count);
    SetMoments(render, first, count);
    return render;
}

TEST(Merge, EqualsOneRenderOfAllSamples) {
    const RenderFile merged = Merge({{"b", Range(20, 44)}, {"a", Range(0, 19)}, {"c", Range(19, 1)}});
    const RenderFile whole = Range(0, 64);
    EXPECT_EQ(merged.samples, whole.samples);
    for (size_t i = 0; i < whole.radiance.size(); i++) {
        EXPECT_NEAR(merged.radiance[i], whole.radiance[i], 2e-7f) << i;
        EXPECT_NEAR(merged.variance[i], whole.variance[i], 2e-7f) << i;
        EXPECT_NEAR(merged.albedo[i], whole.albedo[i], 2e-7f) << i;
    }
}

TEST(Merge, RemovedLightIsWeighedByTheSamplesThatHadTwins) {
    const auto part = [](uint32_t first, uint32_t twins, float mean, float variance) {
        RenderFile render = Range(first, 16 * twins);
        render.removed[1].assign(render.radiance.size(), mean);
        render.removedVariance[1].assign(render.radiance.size(), variance);
        render.removedSamples = twins;
        return render;
    };
    // 2; and 3, 4, 5
    const RenderFile merged = Merge({{"a", part(0, 1, 2.0f, 0.0f)}, {"b", part(16, 3, 4.0f, 1.0f)}});
    EXPECT_EQ(merged.removedSamples, 4u);
    EXPECT_FLOAT_EQ(merged.removed[1][5], 3.5f);
    EXPECT_FLOAT_EQ(merged.removedVariance[1][5], 5.0f / 3.0f);
    EXPECT_TRUE(merged.removed[0].empty());
}

TEST(Merge, KeepsTheListOfSeparateRanges) {
    const RenderFile merged = Merge({{"a", Range(100, 10)}, {"b", Range(0, 10)}, {"c", Range(10, 5)}});
    EXPECT_EQ(merged.samples, (SampleRanges{{0, 15}, {100, 10}}));
}

TEST(Merge, DepthAndIdsAreThoseOfTheFirst) {
    RenderFile other = Range(8, 8);
    other.depth.assign(other.depth.size(), 3.0f);
    other.instance.assign(other.instance.size(), 5);
    const RenderFile first = Range(0, 8), merged = Merge({{"a", first}, {"b", other}});
    EXPECT_EQ(merged.depth, first.depth);
    EXPECT_EQ(merged.instance, first.instance);
}

TEST(Merge, InfiniteMeansStayInfinite) {
    RenderFile a = Range(0, 4), b = Range(4, 4);
    a.radiance[0] = INFINITY;
    b.radiance[5] = NAN;
    const RenderFile merged = Merge({{"a", a}, {"b", b}});
    EXPECT_FALSE(std::isfinite(merged.radiance[0]));
    EXPECT_TRUE(std::isnan(merged.radiance[5]));
    EXPECT_TRUE(std::isfinite(merged.radiance[1]));
}

TEST(Merge, OverlapNamesBothFilesAndRanges) {
    ExpectError(
        ErrorKind::BadInput,
        [] {
            Merge({{"a.exr", Range(0, 32)}, {"b.exr", Range(64, 8)}, {"c.exr", Range(31, 32)}});
        },
        "a.exr", "c.exr", "0-31", "31-62");
}

TEST(Merge, DifferentPicturesAreRefusedNamingTheDifference) {
    const auto merge = [](auto change) {
        RenderFile other = Range(8, 8);
        change(other);
        return [other] { Merge({{"a.exr", Range(0, 8)}, {"b.exr", other}}); };
    };
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.settings["seed"] = "10"; }), "a.exr",
                "b.exr", "seed: 9 against 10");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.settings["size"] = "3x5"; }),
                "size: 5x3 against 3x5");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.sceneFile = "ball.gltf"; }),
                "scene: box.gltf against ball.gltf");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.sceneHash = "other"; }),
                "box.gltf has changed");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.sceneHash.clear(); }),
                "box.gltf was saved by the editor");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.environmentFile.clear(); }),
                "environment: sky.hdr against none");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.environmentHash.clear(); }),
                "sky.hdr has changed");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.albedo.clear(); }),
                "a.exr has the channels of albedo, b.exr has not");
}

}  // namespace
}  // namespace raygraph::cli
