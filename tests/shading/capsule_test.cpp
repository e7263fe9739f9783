// Rays against spheres and capsules, and points of their surfaces, against distances in double.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

#include "core/capsule.glsl"
#include "core/ray_offset.glsl"

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
