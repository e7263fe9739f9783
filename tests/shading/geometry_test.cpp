// Frames, ray offsets and environment directions.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/equirect.glsl"
#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "tests/support/chi_square.h"

namespace raygraph::shading {
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

struct OffsetOutcome {
    int behindCount = 0;       // New origins that are not strictly on the normal's side of the plane.
    double largestMove = 0.0;  // Relative to the size of the coordinates.
};

// Points on triangles of extent `extent` about places of distance up to `distance` from the world's origin,
// offset to both sides; sides are judged in double against the plane through the float vertices.
OffsetOutcome OffsetPoints(float distance, float extent, uint32_t seed) {
    std::mt19937 generator(seed);
    OffsetOutcome outcome;
    for (int i = 0; i < 100'000; ++i) {
        const vec3 center = UnitVector(generator) * distance * Uniform(generator);
        const vec3 v0 = center + UnitVector(generator) * extent;
        const vec3 v1 = center + UnitVector(generator) * extent;
        const vec3 v2 = center + UnitVector(generator) * extent;
        const glm::dvec3 exactNormal =
            glm::cross(glm::dvec3(v1) - glm::dvec3(v0), glm::dvec3(v2) - glm::dvec3(v0));
        // Slivers have no normal worth the name.
        if (glm::length(exactNormal) < 0.05 * extent * extent) continue;
        const vec3 normal = normalize(cross(v1 - v0, v2 - v0));
        const float b1 = std::sqrt(Uniform(generator));
        const float b2 = (1.0f - b1) * Uniform(generator);
        const vec3 p = (1.0f - b1 - b2) * v0 + b1 * v1 + b2 * v2;
        for (float side : {1.0f, -1.0f}) {
            const vec3 origin = OffsetRayOrigin(p, side * normal);
            const double height =
                side * glm::dot(glm::normalize(exactNormal), glm::dvec3(origin) - glm::dvec3(v0));
            if (!(height > 0.0)) ++outcome.behindCount;
            const double size = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z), 1.0f});
            outcome.largestMove =
                std::max(outcome.largestMove, static_cast<double>(length(origin - p)) / size);
        }
    }
    return outcome;
}

TEST(RayOffset, LeavesTheSurfaceOnTheSideOfTheNormal) {
    struct Place {
        float distance, extent;
    };
    // Tiny things at the origin, rooms, towns far from it, a plain of a million units.
    for (const Place& place : {Place{0.01f, 0.001f}, Place{0.01f, 0.01f}, Place{1.0f, 0.01f},
                               Place{1.0f, 1.0f}, Place{10.0f, 0.1f}, Place{10.0f, 10.0f}, Place{1e3f, 1.0f},
                               Place{1e3f, 100.0f}, Place{1e5f, 1e3f}, Place{1e6f, 1e4f}}) {
        const OffsetOutcome outcome = OffsetPoints(place.distance, place.extent, 3);
        EXPECT_EQ(outcome.behindCount, 0) << place.distance << ' ' << place.extent;
        // 256 steps of 2^-23, twice that after a power of two, on each axis.
        EXPECT_LT(outcome.largestMove, 1.1e-4) << place.distance << ' ' << place.extent;
    }
}

TEST(RayOffset, MovesEveryCoordinateAlongItsNormal) {
    for (float size : {1e-30f, 1e-6f, 0.031f, 0.032f, 1.0f, 255.9f, 1e6f}) {
        for (float p : {size, -size}) {
            for (float n : {1.0f, -1.0f, 0.25f, -0.25f}) {
                const float moved = OffsetCoordinate(p, n);
                EXPECT_EQ(moved > p, n > 0.0f) << p << ' ' << n;
                EXPECT_NE(moved, p) << p << ' ' << n;
            }
            EXPECT_EQ(OffsetCoordinate(p, 0.0f), p);
        }
    }
    EXPECT_GT(OffsetCoordinate(0.0f, 1.0f), 0.0f);
    EXPECT_LT(OffsetCoordinate(-0.0f, -1.0f), 0.0f);
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
    // At a quarter turn what was at +x is seen at -z.
    const float quarter = static_cast<float>(M_PI / 2.0);
    EXPECT_NEAR(EquirectFromDirection(vec3(0.0f, 0.0f, -1.0f), quarter).x, 0.5f, 1e-6f);
    EXPECT_LT(length(DirectionFromEquirect(vec2(0.5f, 0.5f), quarter) - vec3(0.0f, 0.0f, -1.0f)), 1e-6f);
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
}  // namespace raygraph::shading
