// The measure by which deforming structures are rebuilt: what a rebuild would gain, and nothing else.
#include "renderer/gpu_scene/refit_quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace raygraph::testing {
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

}  // namespace

TEST(RefitQuality, WhatMovesAsAWholeDoesNotDecay) {
    const std::vector<vec3> rest = SheetSample();
    RefitQuality quality;
    quality.NoteBuild(rest);
    EXPECT_EQ(quality.Decay(rest), 1.0f);
    const auto expectGood = [&](const std::vector<vec3>& corners, const char* what) {
        EXPECT_LT(quality.Decay(corners), RefitQuality::kMaxDecay) << what;
    };
    expectGood(Moved(rest, [](const vec3& p) { return p + vec3(100, -50, 7); }), "moved");
    expectGood(Moved(rest, [](const vec3& p) { return vec3(-p.y, p.x, p.z); }), "turned by a quarter");
    expectGood(Moved(rest, [](const vec3& p) { return vec3(p.x, 2.5f * p.y, p.z); }), "stretched");
    expectGood(
        Moved(rest, [](const vec3& p) { return vec3(p.x, std::sin(0.4f * p.y), std::cos(0.4f * p.y)); }),
        "bent");
}

TEST(RefitQuality, WhatIsScrambledDecaysUntilItIsBuiltAgain) {
    const std::vector<vec3> rest = SheetSample();
    RefitQuality quality;
    quality.NoteBuild(rest);
    std::vector<vec3> scrambled = rest;
    const size_t count = rest.size() / 3;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < 3; ++k) scrambled[3 * (i * 37 % count) + k] = rest[3 * i + k];
    EXPECT_GT(quality.Decay(scrambled), 2.0f);
    quality.NoteBuild(scrambled);
    EXPECT_EQ(quality.Decay(scrambled), 1.0f);
    EXPECT_GT(quality.Decay(rest), 2.0f);
}

TEST(RefitQuality, PointsAndNothingHaveNoQualityToLose) {
    RefitQuality quality;
    EXPECT_EQ(quality.Decay({}), 1.0f);
    quality.NoteBuild({});
    EXPECT_EQ(quality.Decay({}), 1.0f);
    const std::vector<vec3> point(3 * 8, vec3(1.0f));
    quality.NoteBuild(point);
    EXPECT_EQ(quality.Decay(point), 1.0f);
}

}  // namespace raygraph::testing
