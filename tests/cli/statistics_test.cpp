#include <cmath>

#include "editor/cli/content_hash.h"
#include "editor/cli/image_statistics.h"
#include "editor/cli/pass_times.h"
#include "tests/cli/cli_test.h"

namespace raygraph::cli {
namespace {

TEST(ImageStatistics, RelativeErrorIsTheStandardErrorOverTheMean) {
    // Two pixels: mean 2, variance of a sample 9; 9 samples make a standard error of 1
    const std::vector<float> mean{1, 2, 3, 1, 1, 2, 3, 1}, variance{9, 9, 9, 0, 9, 9, 9, 0};
    const ImageStatistics statistics = Measure(mean, variance, 9);
    EXPECT_EQ(statistics.mean, (std::array<double, 3>{1, 2, 3}));
    ASSERT_TRUE(statistics.relativeError);
    EXPECT_DOUBLE_EQ(*statistics.relativeError, 0.5);
    EXPECT_EQ(statistics.nonFinitePixels, 0u);
}

TEST(ImageStatistics, BrokenPixelsAreCountedAndLeftOut) {
    const std::vector<float> mean{2, 2, 2, 1, NAN, INFINITY, 0, 1, 0, 0, -INFINITY, 1, 4, 4, 4, 1};
    const ImageStatistics statistics = Measure(mean, std::vector<float>(16, 0.0f), 4);
    EXPECT_EQ(statistics.nonFinitePixels, 2u);
    EXPECT_EQ(statistics.mean, (std::array<double, 3>{3, 3, 3}));
    EXPECT_EQ(statistics.relativeError, 0.0);
}

TEST(ImageStatistics, NoErrorWithoutTwoSamplesVarianceOrLight) {
    const std::vector<float> light{1, 1, 1, 1}, black{0, 0, 0, 1};
    EXPECT_FALSE(Measure(light, light, 1).relativeError);
    EXPECT_FALSE(Measure(light, {}, 8).relativeError);
    EXPECT_FALSE(Measure(black, black, 8).relativeError);
    EXPECT_FALSE(Measure({}, {}, 8).relativeError);
}

TEST(PassTimes, MedianIsTheMiddleOrTheMeanOfTheTwo) {
    EXPECT_EQ(Median({}), 0.0);
    EXPECT_EQ(Median({3, 1, 2}), 2.0);
    EXPECT_EQ(Median({4, 1, 3, 2}), 2.5);
}

TEST(PassTimes, PassesOfOneNameInAFrameAddUp) {
    PassTimes times;
    const auto frame = [](double trace) {
        FrameTiming timing;
        timing.passes = {{"Trace", 0.0, trace}, {"Accumulate", 0.0, 1.0}, {"Accumulate", 0.0, 2.0}};
        return timing;
    };
    times.Add(std::vector<FrameTiming>{frame(10), frame(30), frame(11)});
    const std::vector<PassTime> summary = times.Summary();
    ASSERT_EQ(summary.size(), 2u);
    EXPECT_EQ(summary[0].name, "Trace");
    EXPECT_EQ(summary[0].gpuMsMedian, 11.0);
    EXPECT_EQ(summary[0].gpuMsTotal, 51.0);
    EXPECT_EQ(summary[0].count, 3u);
    EXPECT_EQ(summary[1].gpuMsMedian, 3.0);
    EXPECT_EQ(times.MedianMs("Tonemap"), 0.0);
}

scene::SceneData TriangleScene() {
    scene::SceneData data;
    data.materials.resize(1);
    data.meshes.resize(1);
    scene::Primitive& primitive = data.meshes[0].primitives.emplace_back();
    primitive.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    primitive.indices = {0, 1, 2};
    data.instances.resize(1);
    data.textures.resize(1);
    data.images.push_back({"", 1, 1, {1, 2, 3, 4}});
    data.cameras.resize(1);
    data.lights.resize(1);
    return data;
}

TEST(ContentHash, ChangesWithAnythingThatThePictureDependsOn) {
    const std::string hash = HashOf(TriangleScene());
    EXPECT_EQ(hash.size(), 16u);
    EXPECT_EQ(HashOf(TriangleScene()), hash);
    const auto changed = [&](auto change) {
        scene::SceneData data = TriangleScene();
        change(data);
        return HashOf(data) != hash;
    };
    using Data = scene::SceneData;
    EXPECT_TRUE(changed([](Data& d) { d.meshes[0].primitives[0].positions[2].y = 1.0000001f; }));
    EXPECT_TRUE(changed([](Data& d) { d.meshes[0].primitives[0].indices = {0, 2, 1}; }));
    EXPECT_TRUE(changed([](Data& d) { d.materials[0].baseColorFactor.x = 0.5f; }));
    EXPECT_TRUE(changed([](Data& d) { d.materials[0].emissiveStrength = 2.0f; }));
    EXPECT_TRUE(changed([](Data& d) { d.instances[0].objectToWorld[3].x = 1.0f; }));
    EXPECT_TRUE(changed([](Data& d) { d.images[0].rgba[3] = 5; }));
    EXPECT_TRUE(changed([](Data& d) { d.textures[0].colorSpace = scene::ColorSpace::Srgb; }));
    EXPECT_TRUE(changed([](Data& d) { d.cameras[0].yFov = 1.0f; }));
    EXPECT_TRUE(changed([](Data& d) { d.lights[0].intensity = 2.0f; }));
    EXPECT_FALSE(changed([](Data& d) { d.name = "other"; }));
}

TEST(ContentHash, ChangesWithATexelOfTheEnvironment) {
    const image::ImageF sky{2, 1, std::vector<float>(8, 1.0f)};
    image::ImageF other = sky;
    other.rgba[5] = 1.5f;
    EXPECT_NE(HashOf(sky), HashOf(other));
    const image::ImageF tall{1, 2, sky.rgba};
    EXPECT_NE(HashOf(sky), HashOf(tall));
}

}  // namespace
}  // namespace raygraph::cli
