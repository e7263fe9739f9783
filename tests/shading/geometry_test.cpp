// Frames, unit vectors and environment directions.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/equirect.glsl"
#include "core/frame.glsl"
#include "shared/unit_vector.h"
#include "tests/support/chi_square.h"

namespace raygraph::shading::geometry_test {
namespace {

float Uniform(std::mt19937& generator) {
    return static_cast<float>(generator() >> 8) * 0x1p-24f;
}

vec3 UnitVector(std::mt19937& generator) {
    std::normal_distribution<float> normal;
    vec3 v(0.0f);
    while (length(v) < 1e-3f) v = vec3(normal(generator), normal(generator), normal(generator));
    return normalize(v);
}

TEST(Math, FiniteIsNeitherNaNNorInfinite) {
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float broken : {infinity, -infinity, std::numeric_limits<float>::quiet_NaN()}) {
        EXPECT_FALSE(IsFinite(broken));
        for (int c = 0; c < 3; ++c) {
            vec3 v(1.0f);
            v[c] = broken;
            EXPECT_FALSE(IsFinite(v)) << c;
        }
    }
    for (const float number : {0.0f, -1.0f, 1e-45f, std::numeric_limits<float>::max()})
        EXPECT_TRUE(IsFinite(vec3(number))) << number;
}

std::vector<vec3> EdgeNormals() {
    std::vector<vec3> normals;
    for (float s : {1.0f, -1.0f}) {
        normals.emplace_back(s, 0.0f, 0.0f);
        normals.emplace_back(0.0f, s, 0.0f);
        normals.emplace_back(0.0f, 0.0f, s);
        normals.emplace_back(-0.0f, -0.0f, s);
        normals.emplace_back(s, 0.0f, -0.0f);
        // Around the switch of sign and around the poles.
        for (float tiny : {1e-38f, 1e-20f, 1e-8f, 1e-4f}) {
            normals.push_back(normalize(vec3(1.0f, 0.3f, s * tiny)));
            normals.push_back(normalize(vec3(s * tiny, tiny, 1.0f)));
            normals.push_back(normalize(vec3(s * tiny, tiny, -1.0f)));
        }
    }
    return normals;
}

TEST(Frame, IsOrthonormalAndRightHandedForAllNormals) {
    std::mt19937 generator(1);
    std::vector<vec3> normals = EdgeNormals();
    for (int i = 0; i < 200'000; ++i) normals.push_back(UnitVector(generator));
    for (vec3 n : normals) {
        const Frame frame = FrameFromZ(n);
        ASSERT_EQ(frame.z, n);
        ASSERT_NEAR(dot(frame.x, frame.x), 1.0f, 1e-6f) << n.x << ' ' << n.y << ' ' << n.z;
        ASSERT_NEAR(dot(frame.y, frame.y), 1.0f, 1e-6f) << n.x << ' ' << n.y << ' ' << n.z;
        ASSERT_NEAR(dot(frame.x, frame.y), 0.0f, 1e-6f) << n.x << ' ' << n.y << ' ' << n.z;
        ASSERT_NEAR(dot(frame.x, frame.z), 0.0f, 1e-6f) << n.x << ' ' << n.y << ' ' << n.z;
        ASSERT_NEAR(dot(frame.y, frame.z), 0.0f, 1e-6f) << n.x << ' ' << n.y << ' ' << n.z;
        ASSERT_NEAR(dot(cross(frame.x, frame.y), frame.z), 1.0f, 1e-6f);
    }
}

TEST(UnitVector, HasOneLengthWhateverThatOfTheVector) {
    std::mt19937 generator(7);
    for (int i = 0; i < 10'000; ++i) {
        const vec3 v = UnitVector(generator) * std::exp(8.0f * Uniform(generator) - 4.0f);
        const vec3 unit = UnitOr(v, vec3(0.0f));
        ASSERT_NEAR(length(unit), 1.0f, 3e-7f);
        ASSERT_EQ(unit, v * inversesqrt(dot(v, v))) << "no other bits where squares are in range";
        ASSERT_EQ(InverseLength(v), inversesqrt(dot(v, v)));
        for (const float size : {0x1p-100f, 0x1p-80f, 0x1p-70f, 0x1p70f, 0x1p100f, 0x1p118f}) {
            ASSERT_EQ(UnitOr(size * v, vec3(0.0f)), unit) << size;
            ASSERT_EQ(InverseLength(size * v), InverseLength(v) / size) << size;
        }
    }
    EXPECT_NEAR(UnitOr(vec3(0.0f, -2e-38f, 0.0f), vec3(0.0f)).y, -1.0f, 1e-6f);
    EXPECT_NEAR(UnitOr(vec3(1e38f, 0.0f, 0.0f), vec3(0.0f)).x, 1.0f, 1e-6f);
}

// A device may take such numbers for zero; where it does not, 1 / length may be infinite.
TEST(UnitVector, DenormalVectorsGiveTheOther) {
    const vec3 other(0.0f, 0.0f, 1.0f);
    for (float size = std::numeric_limits<float>::denorm_min(); std::fpclassify(size) == FP_SUBNORMAL;
         size *= 2.0f)
        for (const vec3 v : {vec3(size, 0, 0), vec3(0, -size, 0), vec3(-size, size, size)}) {
            EXPECT_EQ(UnitOr(v, other), other) << v.x << ' ' << v.y << ' ' << v.z;
            EXPECT_EQ(InverseLength(v), 0.0f) << v.x << ' ' << v.y << ' ' << v.z;
        }
}

TEST(UnitVector, VectorsWithoutADirectionGiveTheOther) {
    const vec3 other(0.0f, 0.0f, 1.0f);
    const float infinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const vec3 v : {vec3(0.0f), vec3(-0.0f), vec3(infinity, 0, 0), vec3(1, -infinity, 0),
                         vec3(nan, 1, 2), vec3(1, nan, 2), vec3(1, 2, nan), vec3(3e38f, 0, 0)}) {
        EXPECT_EQ(UnitOr(v, other), other) << v.x << ' ' << v.y << ' ' << v.z;
        EXPECT_EQ(InverseLength(v), 0.0f) << v.x << ' ' << v.y << ' ' << v.z;
    }
}

TEST(Frame, LocalAndWorldAreInverse) {
    std::mt19937 generator(2);
    for (int i = 0; i < 100'000; ++i) {
        const Frame frame = FrameFromZ(UnitVector(generator));
        const vec3 v = UnitVector(generator);
        ASSERT_LT(length(FromLocal(frame, ToLocal(frame, v)) - v), 1e-6f);
    }
    const Frame frame = FrameFromZ(normalize(vec3(1.0f, 2.0f, -3.0f)));
    EXPECT_LT(length(ToLocal(frame, frame.z) - vec3(0.0f, 0.0f, 1.0f)), 1e-6f);
    EXPECT_LT(length(FromLocal(frame, vec3(1.0f, 0.0f, 0.0f)) - frame.x), 1e-6f);
}

TEST(Equirect, AxesAreWhereTheConventionPutsThem) {
    const auto expectUv = [](vec3 d, float u, float v) {
        const vec2 uv = EquirectFromDirection(d, 0.0f);
        EXPECT_NEAR(uv.x, u, 1e-6f);
        EXPECT_NEAR(uv.y, v, 1e-6f);
    };
    expectUv(vec3(1.0f, 0.0f, 0.0f), 0.5f, 0.5f);
    expectUv(vec3(0.0f, 0.0f, 1.0f), 0.75f, 0.5f);
    expectUv(vec3(0.0f, 0.0f, -1.0f), 0.25f, 0.5f);
    expectUv(vec3(0.0f, 1.0f, 0.0f), 0.5f, 0.0f);
    expectUv(vec3(0.0f, -1.0f, 0.0f), 0.5f, 1.0f);
    const float seam = EquirectFromDirection(vec3(-1.0f, 0.0f, 0.0f), 0.0f).x;
    EXPECT_LT(min(seam, 1.0f - seam), 1e-6f);
}

TEST(Equirect, RotationTurnsTheEnvironmentCounterClockwiseSeenFromAbove) {
    // After a quarter turn, the texel of +x is seen at -z.
    const float quarter = static_cast<float>(M_PI / 2.0);
    EXPECT_NEAR(EquirectFromDirection(vec3(0.0f, 0.0f, -1.0f), quarter).x, 0.5f, 1e-6f);
    EXPECT_LT(length(DirectionFromEquirect(vec2(0.5f, 0.5f), quarter) - vec3(0.0f, 0.0f, -1.0f)), 1e-6f);
}

TEST(Equirect, AQuarterTurnIsTheDefinitionOfOpenExr) {
    // ImfEnvmap.h: longitudes go from pi at the left to -pi; 0 is +z, and pi/2 is +x
    for (const float u : {0.05f, 0.25f, 0.5f, 0.6f, 0.75f, 0.9f}) {
        const double longitude = M_PI * (1.0 - 2.0 * double{u});
        const vec3 defined(static_cast<float>(std::sin(longitude)), 0.0f,
                           static_cast<float>(std::cos(longitude)));
        EXPECT_LT(length(DirectionFromEquirect(vec2(u, 0.5f), static_cast<float>(-M_PI / 2.0)) - defined),
                  1e-6f);
    }
}

TEST(Equirect, DirectionsSurviveTheRoundTrip) {
    std::mt19937 generator(4);
    for (int i = 0; i < 100'000; ++i) {
        const vec3 d = UnitVector(generator);
        const float rotation = 14.0f * Uniform(generator) - 7.0f;
        const vec2 uv = EquirectFromDirection(d, rotation);
        ASSERT_GE(uv.x, 0.0f);
        ASSERT_LT(uv.x, 1.0f);
        ASSERT_GE(uv.y, 0.0f);
        ASSERT_LE(uv.y, 1.0f);
        ASSERT_LT(length(DirectionFromEquirect(uv, rotation) - d), 5e-6f) << d.x << ' ' << d.y << ' ' << d.z;
    }
    // Just below the seam rounding must not give u = 1.
    EXPECT_LT(EquirectFromDirection(vec3(-1.0f, 0.0f, 1e-30f), 0.0f).x, 1.0f);
    EXPECT_LT(EquirectFromDirection(vec3(-1.0f, 0.0f, -1e-9f), 0.0f).x, 1.0f);
}

TEST(Equirect, UniformTexelsGiveADensityOverSolidAngle) {
    const auto pdf = [](vec3 w) {
        return static_cast<double>(
            EquirectSolidAnglePDF(1.0f, EquirectFromDirection(vec3(w.x, w.z, w.y), 0.0f).y));
    };
    // Has an integrable pole at +y and -y, so only a band is integrated: a band of half the rows holds a
    // half.
    const double z = std::cos(M_PI * 0.25);
    EXPECT_NEAR(test::IntegrateOverSphere(pdf, -z, z, 0.0, 2.0 * M_PI), 0.5, 1e-5);
    EXPECT_EQ(EquirectSolidAnglePDF(1.0f, 0.0f), 0.0f);
}

}  // namespace
}  // namespace raygraph::shading::geometry_test
