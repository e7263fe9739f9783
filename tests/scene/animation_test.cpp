// The value of an animation's sampler at a time, against values computed by hand.
#include "renderer/scene/animation/animation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace raygraph::scene::animation_test {
namespace {

double Number(const AnimationSampler& sampler, double seconds, uint32_t interval = 0) {
    double value = 0.0;
    SampleAnimation(sampler, seconds, false, interval, &value);
    return value;
}

using Rotation = std::array<double, 4>;
Rotation RotationAt(const AnimationSampler& sampler, double seconds) {
    Rotation value{};
    uint32_t interval = 0;
    SampleAnimation(sampler, seconds, true, interval, value.data());
    return value;
}

// x, y, z, w of a turn about +z.
std::array<float, 4> AboutZ(double radians) {
    return {0, 0, float(std::sin(radians / 2)), float(std::cos(radians / 2))};
}
AnimationSampler Turns(std::vector<double> angles) {
    AnimationSampler sampler{.width = 4, .times = {}, .values = {}};
    for (const double angle : angles) {
        sampler.times.push_back(float(sampler.times.size()));
        const std::array<float, 4> key = AboutZ(angle);
        sampler.values.insert(sampler.values.end(), key.begin(), key.end());
    }
    return sampler;
}
double AngleOf(const Rotation& q) {
    return 2.0 * std::atan2(q[2], q[3]);
}

TEST(AnimationSampler, LinearIsStraightBetweenItsKeysAndHeldOutside) {
    const AnimationSampler sampler{.times = {1, 2, 4}, .values = {10, 20, 0}};
    EXPECT_EQ(Number(sampler, -5), 10);
    EXPECT_EQ(Number(sampler, 1), 10);
    EXPECT_DOUBLE_EQ(Number(sampler, 1.25), 12.5);
    EXPECT_EQ(Number(sampler, 2), 20);
    EXPECT_DOUBLE_EQ(Number(sampler, 2.5), 15);
    EXPECT_EQ(Number(sampler, 4), 0);
    EXPECT_EQ(Number(sampler, 1e9), 0);
    EXPECT_EQ(Number(sampler, std::numeric_limits<double>::quiet_NaN()), 10);
    EXPECT_EQ(Number(sampler, std::numeric_limits<double>::infinity()), 0);
}

TEST(AnimationSampler, StepHoldsTheKeyBefore) {
    const AnimationSampler sampler{
        .interpolation = Interpolation::Step, .times = {1, 2, 4}, .values = {10, 20, 0}};
    EXPECT_EQ(Number(sampler, 1.999), 10);
    EXPECT_EQ(Number(sampler, 2), 20);
    EXPECT_EQ(Number(sampler, 3.999), 20);
    EXPECT_EQ(Number(sampler, 4), 0);
}

// p(t) of appendix C.5 with p0 = 1, m0 = 2 * 3, p1 = 5, m1 = 2 * (-4), over an interval of 2 s. At t = 1/4:
// h00 = 27/32, h10 = 9/64, h01 = 5/32, h11 = -3/64.
TEST(AnimationSampler, CubicSplineScalesItsTangentsByTheInterval) {
    const AnimationSampler sampler{
        .interpolation = Interpolation::CubicSpline, .times = {10, 12}, .values = {99, 1, 3, -4, 5, 77}};
    const double expected = 27.0 / 32 * 1 + 9.0 / 64 * 6 + 5.0 / 32 * 5 - 3.0 / 64 * -8;
    EXPECT_DOUBLE_EQ(Number(sampler, 10.5), expected);
    // Values, not tangents, at the ends and outside
    EXPECT_EQ(Number(sampler, 10), 1);
    EXPECT_EQ(Number(sampler, 12), 5);
    EXPECT_EQ(Number(sampler, 0), 1);
    EXPECT_EQ(Number(sampler, 20), 5);
    // The slopes at the ends are the tangents, per second
    EXPECT_NEAR((Number(sampler, 10 + 1e-6) - 1) / 1e-6, 3, 1e-4);
    EXPECT_NEAR((5 - Number(sampler, 12 - 1e-6)) / 1e-6, -4, 1e-4);
}

TEST(AnimationSampler, CubicSplineTakesEachKeysOwnTriple) {
    const AnimationSampler sampler{.interpolation = Interpolation::CubicSpline,
                                   .width = 2,
                                   .times = {0, 1, 2},
                                   .values = {0, 0, 1, 2, 0, 0, 0, 0, 3, 4, 0, 0, 0, 0, 5, 6, 0, 0}};
    double value[2];
    uint32_t interval = 0;
    SampleAnimation(sampler, 1.5, false, interval, value);
    EXPECT_DOUBLE_EQ(value[0], 4);
    EXPECT_DOUBLE_EQ(value[1], 5);
}

TEST(AnimationSampler, RotationsTurnAtConstantSpeed) {
    const AnimationSampler sampler = Turns({0.0, 2.0});
    for (const double share : {0.1, 0.25, 0.5, 0.9})
        EXPECT_NEAR(AngleOf(RotationAt(sampler, share)), 2.0 * share, 1e-6) << share;
}

TEST(AnimationSampler, RotationsTakeTheShorterArc) {
    // A turn by 3 and one by -3 are 0.28 apart, through pi; the second key with all signs changed is the same
    const AnimationSampler sampler = Turns({3.0, -3.0});
    const double half = AngleOf(RotationAt(sampler, 0.5));
    EXPECT_NEAR(std::abs(half), M_PI, 1e-6);
    AnimationSampler other = Turns({0.0, 1.0});
    for (size_t i = 4; i < 8; ++i) other.values[i] = -other.values[i];
    EXPECT_NEAR(AngleOf(RotationAt(other, 0.5)), 0.5, 1e-6);
}

TEST(AnimationSampler, RotationsHaveUnitLength) {
    AnimationSampler cubic{
        .interpolation = Interpolation::CubicSpline,
        .width = 4,
        .times = {0, 1},
        .values = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0}};
    const Rotation q = RotationAt(cubic, 0.5);
    EXPECT_NEAR(q[2] * q[2] + q[3] * q[3], 1.0, 1e-12);
    // 0.5 * w + (0.5 + 0.125 * 3) * z, normalized
    EXPECT_NEAR(q[2] / q[3], 0.875 / 0.5, 1e-6);
    AnimationSampler held = Turns({0.5});
    for (float& value : held.values) value *= 3.0f;
    EXPECT_NEAR(AngleOf(RotationAt(held, 0.0)), 0.5, 1e-6);
    EXPECT_NEAR(RotationAt(held, 0.0)[3], std::cos(0.25), 1e-6);
}

// Opposite keys whose spline passes through 0 have no rotation there: the one before is kept, without NaN.
TEST(AnimationSampler, SplineThroughNothingKeepsTheKey) {
    const AnimationSampler sampler{
        .interpolation = Interpolation::CubicSpline,
        .width = 4,
        .times = {0, 1},
        .values = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0}};
    EXPECT_EQ(RotationAt(sampler, 0.5), (Rotation{0, 0, 0, 1}));
}

// The value does not depend on the previous time.
TEST(AnimationSampler, RememberedIntervalIsOnlyAHint) {
    AnimationSampler sampler{.times = {}, .values = {}};
    for (int i = 0; i < 100; ++i) {
        sampler.times.push_back(float(i * i));
        sampler.values.push_back(float(i));
    }
    uint32_t interval = 0;
    for (int step = 0; step < 2000; ++step) {
        const double seconds = (step * 7919 % 2000) * 4.9;
        double value = 0.0;
        SampleAnimation(sampler, seconds, false, interval, &value);
        const double root = std::floor(std::sqrt(seconds));
        EXPECT_NEAR(value, root + (seconds - root * root) / (2 * root + 1), 1e-9) << seconds;
        EXPECT_EQ(value, Number(sampler, seconds, uint32_t(step % 120)));
    }
}

}  // namespace
}  // namespace raygraph::scene::animation_test
