// Tests which medium a path is in, with a table of media that the test makes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "scene/ray.glsl"

namespace raygraph::shading {

namespace {

thread_local std::vector<Medium> mediaTable;

Medium MediumAt(uint material) {
    return mediaTable.at(material);
}

}  // namespace

}  // namespace raygraph::shading

#include "integrator/media.glsl"

namespace raygraph::shading::media_test {

namespace {

// Media of these priorities, of indices 1.1, 1.2, ...
void SetMedia(std::vector<uint> priorities) {
    mediaTable.clear();
    for (size_t i = 0; i < priorities.size(); ++i)
        mediaTable.push_back({.extinction = vec3(0.0f),
                              .scattering = vec3(0.0f),
                              .anisotropy = 0.0f,
                              .ior = 1.1f + 0.1f * float(i),
                              .dispersion = 0.0f,
                              .priority = priorities[i]});
}

}  // namespace

TEST(Media, OneVolumeIsEnteredAndLeft) {
    SetMedia({0});
    const Boundary in = CrossBoundary(NoMedia(), 0, true);
    EXPECT_TRUE(in.isReal);
    EXPECT_FLOAT_EQ(RelativeIor(in, kNoWavelength), 1.1f);
    EXPECT_EQ(CurrentMedium(in.beyond), 0u);
    const Boundary out = CrossBoundary(in.beyond, 0, false);
    EXPECT_TRUE(out.isReal);
    EXPECT_FLOAT_EQ(RelativeIor(out, kNoWavelength), 1.0f / 1.1f);
    EXPECT_EQ(CurrentMedium(out.beyond), kVacuum);
}

TEST(Media, SurfaceOfLowerPriorityIsNotThere) {
    SetMedia({2, 1});
    const MediumStack glass = CrossBoundary(NoMedia(), 0, true).beyond;
    const Boundary water = CrossBoundary(glass, 1, true);
    EXPECT_FALSE(water.isReal);
    EXPECT_EQ(CurrentMedium(water.beyond), 0u);
    // Leaving the glass inside the water is a change from glass to water
    const Boundary out = CrossBoundary(water.beyond, 0, false);
    EXPECT_TRUE(out.isReal);
    EXPECT_FLOAT_EQ(RelativeIor(out, kNoWavelength), 1.2f / 1.1f);
    EXPECT_EQ(CurrentMedium(out.beyond), 1u);
}

TEST(Media, AmongEqualsTheLastEnteredIsThere) {
    SetMedia({1, 1, 1});
    MediumStack stack = NoMedia();
    for (const uint material : {0u, 1u, 2u}) {
        stack = CrossBoundary(stack, material, true).beyond;
        EXPECT_EQ(CurrentMedium(stack), material);
    }
    // One in the middle goes without a change
    const Boundary middle = CrossBoundary(stack, 1, false);
    EXPECT_FALSE(middle.isReal);
    EXPECT_EQ(CurrentMedium(middle.beyond), 2u);
    EXPECT_EQ(CurrentMedium(CrossBoundary(middle.beyond, 2, false).beyond), 0u);
}

TEST(Media, OrderOfEnteringDoesNotMatterWherePrioritiesDiffer) {
    SetMedia({3, 0, 7, 5});
    std::mt19937 random(1);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<uint> order{0, 1, 2, 3};
        std::shuffle(order.begin(), order.end(), random);
        MediumStack stack = NoMedia();
        for (const uint material : order) stack = EnterMedium(stack, material);
        std::shuffle(order.begin(), order.end(), random);
        for (const uint expected : {2u, 3u, 0u, 1u}) {
            ASSERT_EQ(CurrentMedium(stack), expected);
            stack = LeaveMedium(stack, expected);
        }
        ASSERT_EQ(CurrentMedium(stack), kVacuum);
    }
}

TEST(Media, VolumeThatWasNeverEnteredIsLeftFromWithin) {
    SetMedia({0});
    const Boundary out = CrossBoundary(NoMedia(), 0, false);
    EXPECT_TRUE(out.isReal);
    EXPECT_FLOAT_EQ(RelativeIor(out, kNoWavelength), 1.0f / 1.1f);
    EXPECT_EQ(CurrentMedium(out.beyond), kVacuum);
}

TEST(Media, MoreVolumesThanFitLoseTheOutermost) {
    SetMedia({0, 0, 0, 0, 0});
    MediumStack stack = NoMedia();
    for (uint material = 0; material < 5; ++material) stack = EnterMedium(stack, material);
    EXPECT_FALSE(IsInMedium(stack, 0));
    for (uint material = 4; material > 0; --material) {
        EXPECT_EQ(CurrentMedium(stack), material);
        stack = LeaveMedium(stack, material);
    }
    EXPECT_EQ(CurrentMedium(stack), kVacuum);
}

TEST(Media, LightFadesExponentially) {
    SetMedia({0});
    mediaTable[0].extinction = vec3(0.0f, 1.0f, 3.0f);
    const vec3 passed = Transmittance(0, 0.5f);
    EXPECT_FLOAT_EQ(passed.x, 1.0f);
    EXPECT_NEAR(passed.y, std::exp(-0.5), 1e-6);
    EXPECT_NEAR(passed.z, std::exp(-1.5), 1e-6);
    EXPECT_EQ(Transmittance(kVacuum, 1e6f), vec3(1.0f));
}

}  // namespace raygraph::shading::media_test
