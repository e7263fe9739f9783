// Capsules, frames, normals, and directions as numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "core/capsule.glsl"
#include "core/equirect.glsl"
#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "shared/unit_vector.h"
#include "tests/support/chi_square.h"

// Rays against spheres and capsules, and points of their surfaces, against distances in double.
namespace raygraph::shading::capsule_test {
namespace {

using glm::dvec3;

float Uniform(std::mt19937& generator) {
    return static_cast<float>(generator() >> 8) * 0x1p-24f;
}

vec3 UnitVector(std::mt19937& generator) {
    std::normal_distribution<float> normal;
    vec3 v(0.0f);
    while (length(v) < 1e-3f) v = vec3(normal(generator), normal(generator), normal(generator));
    return normalize(v);
}

CapsuleRecord Capsule(vec3 p0, vec3 p1, float radius) {
    return {.p0 = p0, .radius = radius, .p1 = p1, .first = 0, .second = 0};
}

// Lengths of 0 (a sphere) to 1000 radii, somewhere within `far` of the origin.
CapsuleRecord RandomCapsule(std::mt19937& generator, float radius, float far) {
    constexpr float kLengths[] = {0.0f, 0.1f, 1.0f, 10.0f, 1000.0f};
    const vec3 p0 = far * Uniform(generator) * UnitVector(generator);
    return Capsule(p0, p0 + radius * kLengths[generator() % 5] * UnitVector(generator), radius);
}

dvec3 NearestOfSegment(const CapsuleRecord& capsule, const dvec3& point) {
    const dvec3 p0(capsule.p0), segment = dvec3(capsule.p1) - p0;
    const double square = glm::dot(segment, segment);
    const double place = square > 0.0 ? glm::clamp(glm::dot(point - p0, segment) / square, 0.0, 1.0) : 0.0;
    return p0 + place * segment;
}

// Returns the distance from the surface; negative inside.
double Height(const CapsuleRecord& capsule, const dvec3& point) {
    return glm::length(point - NearestOfSegment(capsule, point)) - double(capsule.radius);
}

struct ExactChord {
    double enter, leave, depth;
};

// The distance along the line is convex: its minimum is found by golden sections, both ends by bisection.
std::optional<ExactChord> ExactChordOf(const CapsuleRecord& capsule, vec3 origin, vec3 direction) {
    const dvec3 o(origin), d(direction);
    const double size = glm::length(dvec3(capsule.p1) - dvec3(capsule.p0)) + 2.0 * double(capsule.radius);
    const double middle = glm::dot(0.5 * (dvec3(capsule.p0) + dvec3(capsule.p1)) - o, d) / glm::dot(d, d);
    const double reach = size / glm::length(d);
    const auto height = [&](double t) { return Height(capsule, o + t * d); };
    double low = middle - reach, high = middle + reach;
    for (int i = 0; i < 200; ++i) {
        const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
        (height(a) < height(b) ? high : low) = height(a) < height(b) ? b : a;
    }
    const double deepest = 0.5 * (low + high);
    if (height(deepest) >= 0.0) return std::nullopt;
    const auto root = [&](double outside) {
        double inside = deepest;
        for (int i = 0; i < 100; ++i) {
            const double half = 0.5 * (inside + outside);
            (height(half) < 0.0 ? inside : outside) = half;
        }
        return inside;
    };
    return ExactChord{root(middle - reach), root(middle + reach), -height(deepest)};
}

vec3 Toward(std::mt19937& generator, const CapsuleRecord& capsule, vec3 origin) {
    const vec3 place = capsule.p0 + Uniform(generator) * (capsule.p1 - capsule.p0);
    const vec3 target = place + 1.3f * capsule.radius * Uniform(generator) * UnitVector(generator);
    return (0.1f + 5.0f * Uniform(generator)) * (target - origin) / std::max(length(target - origin), 1e-30f);
}

// Returns the float rounding error at the size of the largest intermediate value.
double Rounding(const CapsuleRecord& capsule, vec3 origin) {
    return 0x1p-24 * (double(length(origin - capsule.p0)) + double(length(origin)) +
                      double(length(capsule.p1 - capsule.p0)) + double(capsule.radius));
}

TEST(Capsule, RaysEnterAndLeaveWhereTheDistanceIsTheRadius) {
    std::mt19937 generator(1);
    int hitCount = 0, missCount = 0;
    for (const float radius : {1e-6f, 1e-3f, 1.0f, 1e4f})
        for (const float away : {0.0f, 0.5f, 3.0f, 100.0f, 1e5f})  // radii
            for (int i = 0; i < 2000; ++i) {
                const CapsuleRecord capsule = RandomCapsule(generator, radius, i % 2 ? 10.0f * radius : 0.0f);
                const vec3 from = capsule.p0 + Uniform(generator) * (capsule.p1 - capsule.p0);
                const vec3 origin = from + away * radius * UnitVector(generator);
                const vec3 direction = Toward(generator, capsule, origin);
                const double rounding = Rounding(capsule, origin), speed = double(length(direction));
                const double height = Height(capsule, origin);
                if (!(speed > 0.0) || std::abs(height) < 16.0 * rounding) continue;
                const std::optional<ExactChord> exact = ExactChordOf(capsule, origin, direction);
                const CapsuleHit hit = IntersectCapsule(capsule, origin, direction);
                const bool isHit = exact && exact->leave > 0.0;
                if (isHit != (hit.leave >= 0.0f)) {
                    // Only where rounding decides
                    const double depth = exact ? exact->depth : 0.0;
                    ASSERT_LT(depth, 32.0 * rounding) << radius << ' ' << away;
                    continue;
                }
                (isHit ? hitCount : missCount)++;
                if (!isHit) continue;
                ASSERT_EQ(hit.enter >= 0.0f, height > 0.0) << "inside, a ray enters nowhere";
                // A place is as uncertain as the ray is grazing there
                const auto expectAt = [&](float found, double place) {
                    const dvec3 point = dvec3(origin) + place * dvec3(direction);
                    const dvec3 normal = glm::normalize(point - NearestOfSegment(capsule, point));
                    const double slope = std::abs(glm::dot(normal, dvec3(direction))) / speed;
                    if (slope < 0.02) return;
                    EXPECT_NEAR(double(found), place, 32.0 * rounding / slope / speed)
                        << radius << ' ' << away;
                };
                expectAt(hit.leave, exact->leave);
                if (height > 0.0) expectAt(hit.enter, exact->enter);
            }
    EXPECT_GT(hitCount, 15000);
    EXPECT_GT(missCount, 1000);
}

TEST(Capsule, ATangentRayMissesAndARayJustBelowHits) {
    for (const float length : {0.0f, 3.0f}) {
        const CapsuleRecord capsule = Capsule(vec3(0.0f), vec3(length, 0.0f, 0.0f), 1.0f);
        for (const float x : {0.0f, 0.5f * length}) {
            const vec3 along(0.0f, 0.0f, 1.0f);
            EXPECT_LT(IntersectCapsule(capsule, vec3(x, 1.000001f, -5.0f), along).leave, 0.0f);
            const CapsuleHit hit = IntersectCapsule(capsule, vec3(x, 0.9999f, -5.0f), along);
            EXPECT_NEAR(hit.enter, 5.0f - std::sqrt(1.0f - 0.9999f * 0.9999f), 1e-4f);
            EXPECT_NEAR(hit.leave, 5.0f + std::sqrt(1.0f - 0.9999f * 0.9999f), 1e-4f);
        }
    }
    // Along the axis, through both caps, and parallel to it
    const CapsuleRecord capsule = Capsule(vec3(0.0f), vec3(3.0f, 0.0f, 0.0f), 1.0f);
    const CapsuleHit through = IntersectCapsule(capsule, vec3(-4.0f, 0.0f, 0.0f), vec3(1.0f, 0.0f, 0.0f));
    EXPECT_FLOAT_EQ(through.enter, 3.0f);
    EXPECT_FLOAT_EQ(through.leave, 8.0f);
    EXPECT_LT(IntersectCapsule(capsule, vec3(-4.0f, 1.001f, 0.0f), vec3(1.0f, 0.0f, 0.0f)).leave, 0.0f);
}

// The sizes are powers of two, which keep all digits. They reach from grains of 1e-12 m to planets.
TEST(Capsule, HitsAndNormalsAreTheSameInAllSizes) {
    std::mt19937 generator(9);
    int hitCount = 0;
    for (int i = 0; i < 10'000; ++i) {
        const CapsuleRecord capsule = RandomCapsule(generator, 0.3f, 2.0f);
        const vec3 origin = 4.0f * UnitVector(generator);
        const vec3 direction = Toward(generator, capsule, origin);
        const CapsuleHit hit = IntersectCapsule(capsule, origin, direction);
        if (hit.enter < 0.0f) continue;
        ++hitCount;
        const vec2 place = CapsulePlaceOf(capsule, origin + hit.enter * direction);
        for (const float size : {0x1p-40f, 0x1p33f, 0x1p40f}) {
            const CapsuleRecord sized = Capsule(size * capsule.p0, size * capsule.p1, size * capsule.radius);
            const CapsuleHit same = IntersectCapsule(sized, size * origin, size * direction);
            ASSERT_EQ(same.enter, hit.enter) << size;
            ASSERT_EQ(same.leave, hit.leave) << size;
            ASSERT_EQ(CapsulePlaceOf(sized, size * (origin + hit.enter * direction)), place) << size;
            ASSERT_EQ(CapsulePointAt(sized, place).normal, CapsulePointAt(capsule, place).normal) << size;
        }
    }
    EXPECT_GT(hitCount, 1000);
}

// The textbook's difference of squares keeps no digit of a small sphere far away.
TEST(Capsule, ASmallSphereFarAwayIsHitAtItsSize) {
    std::mt19937 generator(2);
    int hits = 0;
    constexpr int kRays = 20000;
    for (int i = 0; i < kRays; ++i) {
        const vec3 toSphere = 2000.0f * UnitVector(generator);
        const CapsuleRecord sphere = Capsule(toSphere, toSphere, 0.1f);
        // Uniform over a disk of twice the radius
        const Frame frame = FrameFromZ(normalize(toSphere));
        const float r = 0.2f * std::sqrt(Uniform(generator)), angle = 6.2831853f * Uniform(generator);
        const vec3 target = toSphere + r * std::cos(angle) * frame.x + r * std::sin(angle) * frame.y;
        const CapsuleHit hit = IntersectCapsule(sphere, vec3(0.0f), normalize(target));
        if (hit.leave < 0.0f) continue;
        ++hits;
        ASSERT_NEAR(hit.enter, 2000.0f, 0.11f);
    }
    EXPECT_NEAR(double(hits) / kRays, 0.25, 0.012);
}

TEST(Capsule, PlacesOfTheSurfaceReadBackAsTheirPoints) {
    std::mt19937 generator(3);
    for (const float radius : {1e-3f, 1.0f, 300.0f})
        for (int i = 0; i < 30000; ++i) {
            const CapsuleRecord capsule = RandomCapsule(generator, radius, 10.0f * radius);
            const dvec3 segment = dvec3(capsule.p1) - dvec3(capsule.p0);
            const double len = glm::length(segment);
            dvec3 normal(UnitVector(generator));
            // Poles, equators and the body between
            const double where = std::floor(4.0 * double(Uniform(generator)));
            if (len > 0.0 && where == 0.0) normal -= glm::dot(normal, segment) / (len * len) * segment;
            if (len > 0.0 && where == 1.0) normal = 1e-5 * normal - segment / len;
            normal = glm::normalize(normal);
            const double along = len > 0.0 ? glm::dot(normal, segment) / len : 0.0;
            const double place =
                std::abs(along) > 1e-9 ? (along > 0.0 ? 1.0 : 0.0) : double(Uniform(generator));
            const dvec3 exact = dvec3(capsule.p0) + place * segment + double(radius) * normal;
            const vec2 stored = CapsulePlaceOf(capsule, vec3(exact));
            ASSERT_TRUE(stored.x >= 0.0f && stored.x <= 4.0f && stored.y >= -1.0f && stored.y <= 2.0f);
            const CapsulePoint point = CapsulePointAt(capsule, stored);
            const double tolerance = 0x1p-20 * (glm::length(exact) + len + double(radius));
            ASSERT_LT(glm::length(dvec3(point.position) - exact), tolerance)
                << radius << ' ' << len << ' ' << where;
            ASSERT_LT(glm::length(dvec3(point.normal) - normal), 2.0 * tolerance / double(radius) + 1e-6);
            ASSERT_NEAR(double(point.along), len > 0.0 ? place : point.along,
                        0x1p-20 * (1.0 + glm::length(exact) / std::max(len, 1e-30)));
            ASSERT_LT(std::abs(Height(capsule, dvec3(point.position))),
                      0x1p-21 * (double(length(capsule.p0)) + len + double(radius)));
        }
}

// The plane of SurfaceAt at a point of the surface, and its clearance.
struct Leaving {
    vec3 origin;
    vec3 normal;
};
Leaving LeaveFrom(const CapsuleRecord& capsule, const CapsulePoint& point, const mat3& linear,
                  vec3 translation, float side) {
    const Frame frame = FrameFromZ(point.normal);
    const float extent = length(capsule.p1 - capsule.p0) + capsule.radius;
    const float clearance =
        RayClearance(linear, translation, point.position, extent * frame.x, extent * frame.y, point.position);
    const vec3 normal = normalize(glm::transpose(glm::inverse(linear)) * point.normal);
    return {OffsetRayOrigin(linear * point.position + translation, side * normal, clearance), normal};
}

TEST(Capsule, RaysThatLeaveTheSurfaceDoNotMeetItAgain) {
    std::mt19937 generator(4);
    double largest = 0.0;
    for (int i = 0; i < 200'000; ++i) {
        const float radius = std::pow(10.0f, 8.0f * Uniform(generator) - 4.0f);
        const CapsuleRecord capsule = RandomCapsule(generator, radius, 100.0f * radius);
        const CapsulePoint point =
            CapsulePointAt(capsule, vec2(4.0f * Uniform(generator), 3.0f * Uniform(generator) - 1.0f));
        mat3 linear(1.0f);
        vec3 translation(0.0f);
        if (i % 3 != 0) {
            const Frame turn = FrameFromZ(UnitVector(generator));
            linear = mat3(turn.x, 2.0f * turn.y, 0.3f * turn.z);
            translation = 1000.0f * radius * UnitVector(generator);
        }
        const float side = i % 2 ? 1.0f : -1.0f;
        const Leaving leaving = LeaveFrom(capsule, point, linear, translation, side);
        vec3 direction = UnitVector(generator);
        if (i % 5 == 0)
            direction = normalize(direction - 0.9999f * dot(direction, leaving.normal) * leaving.normal);
        if (side * dot(direction, leaving.normal) < 0.0f) direction = -direction;
        const mat3 inverse = glm::inverse(linear);
        const CapsuleHit hit =
            IntersectCapsule(capsule, inverse * (leaving.origin - translation), inverse * direction);
        ASSERT_LT(hit.enter, 0.0f) << "no side of a convex surface sees its outside again: " << radius;
        if (side > 0.0f)
            ASSERT_LT(hit.leave, 0.0f) << radius;
        else
            ASSERT_GE(hit.leave, 0.0f) << "a ray that starts inside leaves: " << radius;
        largest =
            std::max(largest, Height(capsule, glm::dmat3(inverse) * dvec3(leaving.origin - translation)) /
                                  double(radius));
    }
    // The bound is that of a triangle as long as the capsule, up to 100 radii, in object space and in the world.
    EXPECT_LT(largest, 0.0125) << "and starts near it";
}

TEST(Capsule, AllRaysThatStartInsideLeaveOnce) {
    std::mt19937 generator(5);
    for (int i = 0; i < 100'000; ++i) {
        const CapsuleRecord capsule = RandomCapsule(generator, 2.0f, 5.0f);
        const float depth = 1.0f - std::pow(10.0f, -6.0f * Uniform(generator));
        const vec3 origin = capsule.p0 + Uniform(generator) * (capsule.p1 - capsule.p0) +
                            depth * capsule.radius * UnitVector(generator);
        if (Height(capsule, dvec3(origin)) > -16.0 * Rounding(capsule, origin)) continue;
        const vec3 direction = UnitVector(generator);
        const CapsuleHit hit = IntersectCapsule(capsule, origin, direction);
        ASSERT_LT(hit.enter, 0.0f);
        ASSERT_GE(hit.leave, 0.0f);
        ASSERT_LT(std::abs(Height(capsule, dvec3(origin) + double(hit.leave) * dvec3(direction))),
                  1e-5 * (2.0 + double(length(capsule.p1 - capsule.p0))));
    }
}

}  // namespace
}  // namespace raygraph::shading::capsule_test

// Frames, unit vectors and environment directions.
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

// Shading normals are legal for every viewer, and left alone where they are.
namespace raygraph::shading::shading_normal_test {

namespace {

vec3 RandomDirection(std::mt19937& random) {
    std::normal_distribution<float> normal;
    return normalize(vec3(normal(random), normal(random), normal(random)));
}

// wo on the side of ng; ns anywhere on its hemisphere, as interpolation and normal maps may leave it.
struct Views {
    vec3 ng, ns, wo;
};
Views RandomViews(std::mt19937& random) {
    Views views{RandomDirection(random), RandomDirection(random), RandomDirection(random)};
    if (dot(views.wo, views.ng) < 0.0f) views.wo = -views.wo;
    if (dot(views.ns, views.ng) < 0.0f) views.ns = -views.ns;
    return views;
}

float MirrorHeight(vec3 n, vec3 ng, vec3 wo) {
    return dot(2.0f * dot(n, wo) * n - wo, ng);
}

}  // namespace

TEST(ShadingNormal, ViewerAndMirrorDirectionAreAboveTheSurface) {
    std::mt19937 random(7);
    int bentCount = 0;
    for (int trial = 0; trial < 200'000; ++trial) {
        const auto [ng, ns, wo] = RandomViews(random);
        const vec3 adapted = AdaptShadingNormal(ns, ng, wo);
        ASSERT_NEAR(length(adapted), 1.0f, 1e-5f);
        ASSERT_GT(dot(adapted, wo), 0.0f);
        // Halfway vectors of grazing viewers are short and carry rounding
        ASSERT_GT(MirrorHeight(adapted, ng, wo), -2e-4f) << "the mirror direction is inside of the body";
        if (adapted != ns) ++bentCount;
    }
    EXPECT_GT(bentCount, 10'000) << "the test does not try what it is for";
}

TEST(ShadingNormal, LegalOnesAreLeftAlone) {
    std::mt19937 random(8);
    int legalCount = 0;
    for (int trial = 0; trial < 100'000; ++trial) {
        const auto [ng, ns, wo] = RandomViews(random);
        if (dot(ns, wo) <= 0.0f || MirrorHeight(ns, ng, wo) < 0.011f) continue;
        ++legalCount;
        ASSERT_EQ(AdaptShadingNormal(ns, ng, wo), ns);
    }
    EXPECT_GT(legalCount, 10'000);
}

TEST(ShadingNormal, GeometricNormalIsLegalAtGrazingAngles) {
    std::mt19937 random(9);
    for (const float height : {1.0f, 0.1f, 1e-2f, 1e-3f, 1e-5f}) {
        const vec3 ng(0.0f, 0.0f, 1.0f), wo = normalize(vec3(1.0f, 0.0f, height));
        const vec3 adapted = AdaptShadingNormal(ng, ng, wo);
        EXPECT_NEAR(dot(adapted, ng), 1.0f, 1e-6f) << height;
    }
}

TEST(ShadingNormal, BendsWithoutAJump) {
    // Turning ns over the edge of what is legal moves the result by no more than ns itself moved, about
    const vec3 ng(0.0f, 0.0f, 1.0f), wo = normalize(vec3(1.0f, 0.0f, 0.3f));
    vec3 last = AdaptShadingNormal(ng, ng, wo);
    const float step = 1e-3f;
    for (float angle = step; angle < 1.5f; angle += step) {
        const vec3 adapted = AdaptShadingNormal(vec3(-sin(angle), 0.0f, cos(angle)), ng, wo);
        ASSERT_LT(length(adapted - last), 4.0f * step) << "at " << angle;
        last = adapted;
    }
}

// A triangle of the unit sphere, its normals the sphere's.
TEST(ShadowTerminatorOffset, PointsOfATriangleNearTheSphereThatItsNormalsAreOf) {
    std::mt19937 random(3);
    for (int i = 0; i < 200; ++i) {
        const vec3 axis = RandomDirection(random);
        vec3 v[3];
        for (vec3& vertex : v) vertex = normalize(axis + 0.3f * RandomDirection(random));
        const auto lifted = [&](vec3 weights, float side) {
            const vec3 p = weights.x * v[0] + weights.y * v[1] + weights.z * v[2];
            const float size = i % 2 == 0 ? side : 10.0f * side;  // a host's normals may have any length
            return p + ShadowTerminatorOffset(weights, p, v[0], v[1], v[2], size * v[0], size * v[1],
                                              size * v[2]);
        };
        const vec3 middle = (v[0] + v[1] + v[2]) / 3.0f;
        const float gap = 1.0f - length(middle);
        const float height = length(lifted(vec3(1.0f / 3.0f), 1.0f));
        // From the chord to the tangent planes: at most twice the gap
        EXPECT_GE(height, 1.0f - 0.35f * gap - 1e-6f);
        EXPECT_LE(height, 1.0f + 1.1f * gap + 1e-6f);
        EXPECT_LT(length(lifted(vec3(0.0f, 1.0f, 0.0f), 1.0f) - v[1]), 1e-6f) << "a vertex stays";
        EXPECT_LT(length(lifted(vec3(1.0f / 3.0f), -1.0f) - middle), 1e-6f) << "from inside it is hollow";
    }
}

}  // namespace raygraph::shading::shading_normal_test

// Tests of triangles' frames along their texture coordinates, and of how they turn smooth frames.
namespace raygraph::shading::tangent_frame_test {

namespace {

// A unit normal, and two directions perpendicular to it that are no multiples of each other.
struct Plane {
    vec3 n, alongU, alongV;
};

class Random {
  public:
    float Number() { return m_number(m_engine); }
    vec3 Direction() { return normalize(vec3(Number(), Number(), Number())); }
    // Returns an affine map from texture coordinates to space whose axes are at most 70 degrees from a right
    // angle.
    Plane NextPlane() {
        for (;;) {
            Plane plane;
            plane.n = Direction();
            plane.alongU = cross(plane.n, Direction());
            plane.alongV = cross(plane.n, Direction());
            const float sine = dot(plane.n, cross(plane.alongU, plane.alongV)) /
                               (length(plane.alongU) * length(plane.alongV));
            if (std::abs(sine) > 0.34f) return plane;
        }
    }
    // Returns two edges, in texture coordinates, of a triangle that is no sliver.
    glm::mat2 Edges() {
        for (;;) {
            const glm::mat2 edges(Number(), Number(), Number(), Number());
            if (std::abs(determinant(edges)) > 0.3f) return edges;
        }
    }

  private:
    std::mt19937 m_engine{5};
    std::normal_distribution<float> m_number;
};

vec3 Xyz(const vec4& v) {
    return {v.x, v.y, v.z};
}

}  // namespace

// All triangles of an affine map have one frame, whatever their corners and the unit of the coordinates.
TEST(TangentFrame, TriangleTangent_LiesAlongUAndSaysWhereTheImagesTopIs) {
    Random random;
    for (int trial = 0; trial < 20'000; ++trial) {
        Plane plane = random.NextPlane();
        const glm::mat2 uv = random.Edges();
        const float unit = std::exp2(8.0f * random.Number());
        const vec3 e1 = uv[0].x * plane.alongU + uv[0].y * plane.alongV;
        const vec3 e2 = uv[1].x * plane.alongU + uv[1].y * plane.alongV;
        if (dot(cross(e1, e2), plane.n) < 0.0f) plane.n = -plane.n;  // n is on the front, as the winding says
        const vec4 tangent = TriangleTangent(e1, e2, unit * uv[0], unit * uv[1], plane.n);
        ASSERT_NEAR(dot(Xyz(tangent), normalize(plane.alongU)), 1.0f, 1e-4f);
        ASSERT_NEAR(dot(Xyz(tangent), plane.n), 0.0f, 1e-5f);
        // v points downwards
        ASSERT_LT(dot(tangent.w * cross(plane.n, Xyz(tangent)), plane.alongV), 0.0f);
        ASSERT_EQ(std::abs(tangent.w), 1.0f);
        // MikkTSpace's sign is that of the coordinates, whatever side the normal is on
        ASSERT_EQ(TriangleTangent(e1, e2, unit * uv[0], unit * uv[1], -plane.n), tangent);
    }
}

TEST(TangentFrame, TriangleTangent_IsPerpendicularToAnInterpolatedNormal) {
    const vec3 n = normalize(vec3(0.3f, -0.2f, 1.0f));
    const vec4 tangent =
        TriangleTangent(vec3(2, 0, 0), vec3(0, 3, 0), vec2(0.5f, 0.0f), vec2(0.0f, -0.25f), n);
    const vec3 expected = normalize(vec3(1, 0, 0) - n.x * n);
    EXPECT_LT(length(Xyz(tangent) - expected), 1e-6f);
    EXPECT_EQ(tangent.w, 1.0f);
}

TEST(TangentFrame, TriangleTangent_IsNoneWithoutAreaOrDirection) {
    const vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), none(0.0f);
    EXPECT_EQ(TriangleTangent(x, y, vec2(1, 1), vec2(2, 2), z), vec4(0.0f));
    EXPECT_EQ(TriangleTangent(x, y, vec2(0.0f), vec2(0.0f), z), vec4(0.0f));
    EXPECT_EQ(TriangleTangent(none, none, vec2(1, 0), vec2(0, 1), z), vec4(0.0f));
    EXPECT_EQ(TriangleTangent(x, y, vec2(1, 0), vec2(0, 1), x), vec4(0.0f)) << "u grows along the normal";
}

// The triangle's frame is turned exactly into its other frame. A frame that is turned about the normal
// relative to the first is turned by as much relative to the second, and mirrored with it.
TEST(TangentFrame, TurnTangent_TurnsAsTheTrianglesFramesAreTurned) {
    Random random;
    for (int trial = 0; trial < 20'000; ++trial) {
        const Plane plane = random.NextPlane();
        const glm::mat2 uv = random.Edges(), linear = random.Edges();
        const auto edge = [&](int i) { return uv[i].x * plane.alongU + uv[i].y * plane.alongV; };
        const vec4 from = TriangleTangent(edge(0), edge(1), uv[0], uv[1], plane.n);
        const vec4 to = TriangleTangent(edge(0), edge(1), linear * uv[0], linear * uv[1], plane.n);
        ASSERT_EQ(to.w, determinant(linear) < 0.0f ? -from.w : from.w);
        ASSERT_LT(length(TurnTangent(from, from, to, plane.n) - to), 1e-5f);
        // Turns a tangent by 0.3 radians about n
        const auto turned = [&](const vec4& tangent) {
            const vec3 t = std::cos(0.3f) * Xyz(tangent) + std::sin(0.3f) * cross(plane.n, Xyz(tangent));
            return vec4(t.x, t.y, t.z, tangent.w);
        };
        ASSERT_LT(length(TurnTangent(turned(from), from, to, plane.n) - turned(to)), 1e-5f);
    }
}

}  // namespace raygraph::shading::tangent_frame_test
