// The measure by which deforming structures are rebuilt: what a rebuild would gain, and nothing else.
#include "renderer/gpu_scene/geometry/refit_quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/failing_memory.h"

namespace raygraph::testing::refit_quality_test {
namespace {

using glm::vec3;

// Small triangles over a sheet 1 by 4.
std::vector<vec3> SheetSample() {
    std::mt19937 engine(3);
    std::uniform_real_distribution<float> random(0.0f, 1.0f);
    std::vector<vec3> corners;
    for (size_t i = 0; i < RefitQuality::kSampleCount; ++i) {
        const vec3 at(random(engine), 4.0f * random(engine), 0.0f);
        for (const vec3& corner : {vec3(0), vec3(0.05f, 0, 0), vec3(0, 0.05f, 0.01f)})
            corners.push_back(at + corner);
    }
    return corners;
}

template <typename Move>
std::vector<vec3> Moved(std::vector<vec3> corners, Move&& move) {
    for (vec3& corner : corners) corner = move(corner);
    return corners;
}

// Each triangle is where another one was.
std::vector<vec3> Scrambled(const std::vector<vec3>& corners) {
    std::vector<vec3> scrambled = corners;
    const size_t count = corners.size() / 3;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < 3; ++k) scrambled[3 * (i * 37 % count) + k] = corners[3 * i + k];
    return scrambled;
}

}  // namespace

TEST(RefitQuality, WhatMovesAsAWholeDoesNotDecay) {
    const std::vector<vec3> rest = SheetSample();
    RefitQuality quality;
    EXPECT_EQ(quality.Follow(rest), 1.0f);
    quality.OnBuild();
    EXPECT_EQ(quality.Follow(rest), 1.0f);
    const auto expectGood = [&](const std::vector<vec3>& corners, const char* what) {
        EXPECT_LT(quality.Follow(corners), RefitQuality::kMaxDecay) << what;
    };
    expectGood(Moved(rest, [](const vec3& p) { return p + vec3(100, -50, 7); }), "moved");
    expectGood(Moved(rest, [](const vec3& p) { return vec3(-p.y, p.x, p.z); }), "turned by a quarter");
    expectGood(Moved(rest, [](const vec3& p) { return vec3(p.x, 2.5f * p.y, p.z); }), "stretched");
    expectGood(
        Moved(rest, [](const vec3& p) { return vec3(p.x, std::sin(0.4f * p.y), std::cos(0.4f * p.y)); }),
        "bent");
}

TEST(RefitQuality, WhatIsScrambledDecaysUntilItIsBuiltAgain) {
    const std::vector<vec3> rest = SheetSample(), scrambled = Scrambled(rest);
    RefitQuality quality;
    quality.Follow(rest);
    quality.OnBuild();
    EXPECT_GT(quality.Follow(scrambled), 2.0f);
    quality.OnBuild();
    EXPECT_EQ(quality.Follow(scrambled), 1.0f);
    EXPECT_GT(quality.Follow(rest), 2.0f);
    quality.OnBuild();
    quality.OnBuild();  // of another structure, of the same pose
    EXPECT_EQ(quality.Follow(rest), 1.0f);
    EXPECT_GT(quality.Follow(scrambled), 2.0f) << "the build was that of the other pose";
}

// It is told of builds once a frame has been submitted: a failure would end the program.
TEST(RefitQuality, BuildsAreNotedWithoutMemory) {
    const std::vector<vec3> rest = SheetSample(), scrambled = Scrambled(rest);
    RefitQuality quality;
    quality.Follow(rest);
    {
        const FailingMemory none(0);
        quality.OnBuild();
    }
    EXPECT_GT(quality.Follow(scrambled), 2.0f);
    {
        const FailingMemory none(0);
        quality.OnBuild();
    }
    EXPECT_EQ(quality.Follow(scrambled), 1.0f);
}

TEST(RefitQuality, PointsAndNothingHaveNoQualityToLose) {
    RefitQuality quality;
    EXPECT_EQ(quality.Follow({}), 1.0f);
    quality.OnBuild();
    EXPECT_EQ(quality.Follow({}), 1.0f);
    const std::vector<vec3> point(3 * 8, vec3(1.0f));
    RefitQuality ofPoint;
    ofPoint.Follow(point);
    ofPoint.OnBuild();
    EXPECT_EQ(ofPoint.Follow(point), 1.0f);
}

}  // namespace raygraph::testing::refit_quality_test
