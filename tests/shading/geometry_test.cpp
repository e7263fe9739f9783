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

// A placed triangle, and a point of it as scene/surface.glsl computes it.
struct Placed {
    mat3 linear{1.0f};
    vec3 translation{0.0f};
    vec3 p0{0.0f}, e1{0.0f}, e2{0.0f};
    vec2 weights{0.0f};

    vec3 ObjectPoint() const { return p0 + weights.x * e1 + weights.y * e2; }
    vec3 Point() const { return linear * ObjectPoint() + translation; }
    float Clearance() const { return RayClearance(linear, translation, p0, e1, e2, ObjectPoint()); }
    vec3 Normal() const {
        const vec3 n = cross(e1, e2);
        return normalize(n.x * cross(linear[1], linear[2]) + n.y * cross(linear[2], linear[0]) +
                         n.z * cross(linear[0], linear[1]));
    }
};

glm::dvec3 Double(vec3 v) {
    return glm::dvec3(v);
}

glm::dmat3 Double(const mat3& m) {
    return {Double(m[0]), Double(m[1]), Double(m[2])};
}

// Meters of `place` above the plane of the exact triangle, on the side of the normal.
double HeightAbove(const Placed& placed, const glm::dvec3& place) {
    const glm::dmat3 linear = Double(placed.linear);
    const glm::dvec3 normal = glm::normalize(glm::transpose(glm::inverse(linear)) *
                                             glm::cross(Double(placed.e1), Double(placed.e2))) *
                              (glm::determinant(linear) < 0.0 ? -1.0 : 1.0);
    return glm::dot(normal, place - (linear * Double(placed.p0) + Double(placed.translation)));
}

// Where a device that inverts the transform in float and takes the ray's origin into object space in float
// puts the origin, carried back to the world without further error.
glm::dvec3 AsDeviceHasIt(const Placed& placed, vec3 origin) {
    const glm::mat4 matrix(glm::vec4(placed.linear[0], 0.0f), glm::vec4(placed.linear[1], 0.0f),
                           glm::vec4(placed.linear[2], 0.0f), glm::vec4(placed.translation, 1.0f));
    const glm::mat4 inverse = glm::inverse(matrix);
    const vec3 inObject = vec3(inverse[0]) * origin.x + vec3(inverse[1]) * origin.y +
                          vec3(inverse[2]) * origin.z + vec3(inverse[3]);
    return Double(placed.linear) * Double(inObject) + Double(placed.translation);
}

mat3 RandomLinear(std::mt19937& generator, int kind) {
    if (kind == 0) return mat3(1.0f);
    const Frame turn = FrameFromZ(UnitVector(generator));
    const float angle = 6.0f * Uniform(generator);
    const vec3 x = std::cos(angle) * turn.x + std::sin(angle) * turn.y;
    mat3 linear(x, cross(turn.z, x), turn.z);
    if (kind == 1) return linear;
    for (int i = 0; i < 3; ++i) linear[i] *= std::exp(2.0f * Uniform(generator) - 1.0f);
    if (kind == 3) linear[0] = linear[0] + 0.5f * linear[1];  // sheared
    if (kind == 4) linear[2] = -linear[2];                    // mirrored
    return linear;
}

// A triangle of `extent` meters, `far` from its object's origin, at `near` from the world's.
Placed RandomTriangle(std::mt19937& generator, int kind, float extent, float far, float near) {
    Placed placed;
    placed.linear = RandomLinear(generator, kind);
    placed.p0 = far * UnitVector(generator) + extent * UnitVector(generator);
    placed.e1 = (placed.p0 + extent * UnitVector(generator)) - placed.p0;
    placed.e2 = (placed.p0 + extent * UnitVector(generator)) - placed.p0;
    placed.translation = near * UnitVector(generator) - placed.linear * placed.p0;
    const float b1 = std::sqrt(Uniform(generator));
    placed.weights = vec2(b1, (1.0f - b1) * Uniform(generator));
    return placed;
}

TEST(RayClearance, LeavesTheSurfaceInTheWorldAndAsTheDeviceHasIt) {
    struct Place {
        float extent, far, near;
    };
    std::mt19937 generator(3);
    // Tiny things, rooms, towns, vertices and nodes that cancel, and what is far off
    for (const Place& place :
         {Place{0.001f, 0.01f, 0.01f}, Place{1.0f, 1.0f, 10.0f}, Place{1.0f, 1000.0f, 1.0f},
          Place{0.1f, 300.0f, 300.0f}, Place{100.0f, 1.0f, 10000.0f}, Place{1.0f, 1e5f, 10.0f},
          Place{1e4f, 1e6f, 1e6f}}) {
        for (int kind = 0; kind < 5; ++kind) {
            int behindCount = 0;
            double largest = 0.0;  // clearance over the size of a float step of the largest coordinate
            for (int i = 0; i < 20'000; ++i) {
                const Placed placed = RandomTriangle(generator, kind, place.extent, place.far, place.near);
                const float area = length(cross(placed.e1, placed.e2));
                if (area < 0.05f * place.extent * place.extent)
                    continue;  // slivers have a bound of their own
                const float clearance = placed.Clearance();
                for (const float side : {1.0f, -1.0f}) {
                    const vec3 origin = OffsetRayOrigin(placed.Point(), side * placed.Normal(), clearance);
                    if (!(side * HeightAbove(placed, Double(origin)) > 0.0)) ++behindCount;
                    if (!(side * HeightAbove(placed, AsDeviceHasIt(placed, origin)) > 0.0)) ++behindCount;
                }
                const double size = length(placed.Point()) + length(placed.translation) +
                                    length(placed.linear * placed.p0) + place.extent;
                largest = std::max(largest, double{clearance} / (size * 0x1p-23));
            }
            EXPECT_EQ(behindCount, 0)
                << place.extent << ' ' << place.far << ' ' << place.near << ", " << kind;
            // Rotations add up to the root of 3 on each axis, there and back; scale and shear some more
            EXPECT_LT(largest, kind == 0 ? 12.0 : 80.0) << place.far << ' ' << place.near << ", " << kind;
        }
    }
}

// The bound is made of what was rounded, axis by axis: what is exact costs nothing.
TEST(RayClearance, CountsOnlyWhatHasAnErrorAlongTheNormal) {
    Placed wall;  // faces along x, a meter wide, 100 m off along y
    wall.p0 = vec3(0.0f, 100.0f, 0.0f);
    wall.e1 = vec3(0.0f, 1.0f, 0.0f);
    wall.e2 = vec3(0.0f, 0.0f, 1.0f);
    wall.weights = vec2(0.25f, 0.25f);
    const float near = wall.Clearance();
    EXPECT_GT(near, 0.0f);
    EXPECT_LT(near, 1e-6f);
    wall.translation = vec3(0.0f, 10000.0f, 5000.0f);
    EXPECT_LT(wall.Clearance(), 1e-6f) << "moved along itself";
    wall.translation = vec3(1000.0f, 0.0f, 0.0f);
    // Two roundings of its place, six of the terms of the inverse: o.x - t.x
    EXPECT_NEAR(wall.Clearance(), gpu::kRoundoff * (2.0f + 6.0f * 2.0f) * 1000.0f, 1e-5f);
    EXPECT_LT(wall.Clearance(), 0.9e-3f) << "a pane of 1 mm at 1 km";
    wall.translation = vec3(-1000.0f, 0.0f, 0.0f);
    wall.p0.x = 1000.0f;
    // Two of the vertices and three of the transform, and the inverse
    EXPECT_NEAR(wall.Clearance(), gpu::kRoundoff * (2.0f + 3.0f + 6.0f) * 1000.0f, 1e-5f)
        << "the place is near 0, its terms are not";
}

// From triangles of 1e-12 m to those of 1e12 m; their normals are in square meters.
TEST(RayClearance, IsInProportionToTheSizeOfTheWorld) {
    std::mt19937 generator(6);
    for (int i = 0; i < 1000; ++i) {
        const Placed placed = RandomTriangle(generator, 1, 1.0f, 1.0f, 1.0f);
        for (const float size : {0x1p-40f, 0x1p33f, 0x1p40f}) {
            Placed vertices = placed;
            for (vec3* v : {&vertices.p0, &vertices.e1, &vertices.e2, &vertices.translation}) *v *= size;
            const float expected = size * placed.Clearance();
            ASSERT_NEAR(vertices.Clearance(), expected, 1e-5f * expected) << size;
            Placed transform = placed;
            for (int axis = 0; axis < 3; ++axis) transform.linear[axis] *= size;
            transform.translation *= size;
            ASSERT_NEAR(transform.Clearance(), expected, 1e-5f * expected) << size;
        }
    }
}

TEST(RayClearance, GrowsWithTheScaleOfTheWorldAndIsFiniteForSlivers) {
    std::mt19937 generator(5);
    for (int i = 0; i < 1000; ++i) {
        Placed placed = RandomTriangle(generator, 1, 1.0f, 10.0f, 10.0f);
        const float clearance = placed.Clearance();
        placed.linear = mat3(64.0f * placed.linear[0], 64.0f * placed.linear[1], 64.0f * placed.linear[2]);
        placed.translation *= 64.0f;
        EXPECT_NEAR(placed.Clearance(), 64.0f * clearance, 1e-3f * 64.0f * clearance);
        placed = RandomTriangle(generator, 1, 1.0f, 1.0f, 10.0f);
        placed.e2 = placed.e1 + 1e-5f * UnitVector(generator);
        EXPECT_GT(placed.Clearance(), 0.0f);
        EXPECT_LT(placed.Clearance(), 1e-3f);
        placed.e2 = placed.e1;  // without area
        EXPECT_GT(placed.Clearance(), 0.0f);
        EXPECT_LT(placed.Clearance(), 1e-3f);
    }
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
}  // namespace raygraph::shading
