// Ray cones against what bundles of rays do.
#include "core/ray_cone.glsl"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace raygraph::shading::ray_cone_test {
namespace {

// Double precision is needed, since areas below are differences of close numbers.
using Vector = glm::dvec3;
struct Bundle {
    Vector origin[3], direction[3];  // a ray, and neighbors of it in both directions
};

// Rays beside the z axis downwards, with their origins `width` apart and their directions by `spread`.
Bundle BundleOf(double width, double spread) {
    Bundle bundle;
    for (int i = 0; i < 3; ++i) {
        const Vector side(i == 1, i == 2, 0);
        bundle.origin[i] = width * side;
        bundle.direction[i] = glm::normalize(spread * side - Vector(0, 0, 1));
    }
    return bundle;
}

// The width of the bundle where its first ray has gone so far: the root of its cross-section's area.
double WidthAt(const Bundle& bundle, double distance) {
    const Vector along = bundle.direction[0], at = bundle.origin[0] + distance * along;
    Vector side[2];
    for (int i = 0; i < 2; ++i) {
        const Vector origin = bundle.origin[i + 1], direction = bundle.direction[i + 1];
        side[i] = origin + glm::dot(at - origin, along) / glm::dot(direction, along) * direction - at;
    }
    return std::sqrt(std::abs(glm::dot(glm::cross(side[0], side[1]), along)));
}

// Returns where a ray meets the sphere: the near side from outside, the far one from inside.
Vector MeetSphere(const Vector& origin, const Vector& direction, const Vector& center, double radius) {
    const Vector from = origin - center;
    const double b = glm::dot(from, direction), c = glm::dot(from, from) - radius * radius;
    const double root = std::sqrt(b * b - c);
    return origin + (c > 0.0 ? -b - root : -b + root) * direction;
}

TEST(RayCone, LevelOfAPlaneIsThatOfThePixelsAreaOnIt) {
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> uniform;
    const double pixel = 1e-4;      // at distance 1
    const double texel = 1.0 / 64;  // meters
    for (int i = 0; i < 2000; ++i) {
        const Vector film(1.2 * uniform(generator) - 0.6, 1.2 * uniform(generator) - 0.6, -1.0);
        const Vector normal = glm::normalize(
            Vector(1.6 * uniform(generator) - 0.8, 1.6 * uniform(generator) - 0.8, 0.8 + uniform(generator)));
        const double distance = std::exp2(3.0 + 9.0 * uniform(generator));
        const Vector direction = glm::normalize(film), at = distance * direction;
        const double cosine = -glm::dot(direction, normal);
        if (cosine < 0.1) continue;
        // The pixel's corners on the plane
        Vector corners[3];
        for (int c = 0; c < 3; ++c) {
            const Vector to = film + pixel * Vector(c == 1 ? 0.5 : -0.5, c == 2 ? 0.5 : -0.5, 0.0);
            corners[c] = glm::dot(at, normal) / glm::dot(to, normal) * to;
        }
        const double area = glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
        const double expected = std::log2(area / (texel * texel)) / 2.0;
        const RayCone cone = AdvanceCone(PerspectiveCone(float(pixel), float(-direction.z)), float(distance));
        const float seen = FootprintArea(cone.width, float(-cosine));
        for (const double bias : {0.0, 3.0})
            ASSERT_NEAR(TextureLevel(seen / float(texel * texel), 1e9f, float(bias)),
                        std::max(expected + bias, 0.0), 0.01)
                << "distance " << distance << ", cosine " << cosine << ", bias " << bias;
    }
}

TEST(RayCone, BiasIsAddedAndNothingIsSharperThanLevel0) {
    EXPECT_FLOAT_EQ(TextureLevel(4096.0f, 64.0f, 0.0f), 6.0f);
    EXPECT_FLOAT_EQ(TextureLevel(4096.0f, 64.0f, -2.5f), 3.5f);
    EXPECT_FLOAT_EQ(TextureLevel(4096.0f, 64.0f, -7.0f), 0.0f);
    EXPECT_FLOAT_EQ(TextureLevel(0.25f, 64.0f, 0.0f), 0.0f);
    EXPECT_FLOAT_EQ(TextureLevel(0.0f, 64.0f, 0.0f), 0.0f) << "nothing is seen: no cone";
    EXPECT_FLOAT_EQ(TextureLevel(0.0f, 64.0f, -std::numeric_limits<float>::infinity()), 0.0f);
}

TEST(RayCone, TextureOneTexelWideHalvesFromLevelToLevel) {
    EXPECT_FLOAT_EQ(TextureLevel(256.0f, 1.0f, 0.0f), 8.0f) << "all of 1 x 256";
    EXPECT_FLOAT_EQ(TextureLevel(256.0f, 4.0f, 0.0f), 6.0f) << "all of 4 x 64: the last level";
    EXPECT_FLOAT_EQ(TextureLevel(16.0f, 4.0f, 0.0f), 2.0f) << "a square of it";
    EXPECT_FLOAT_EQ(TextureLevel(4.0f, 4.0f, 0.0f), 1.0f);
}

TEST(RayCone, NarrowsToAPointAndWidensBehindIt) {
    const RayCone cone = MakeCone(0.3f, -0.1f);
    EXPECT_FLOAT_EQ(AdvanceCone(cone, 1.0f).width, 0.2f);
    EXPECT_FLOAT_EQ(AdvanceCone(cone, 1.0f).spread, -0.1f);
    const RayCone behind = AdvanceCone(cone, 5.0f);
    EXPECT_FLOAT_EQ(behind.width, 0.2f);
    EXPECT_FLOAT_EQ(behind.spread, 0.1f);
    EXPECT_FLOAT_EQ(AdvanceCone(AdvanceCone(cone, 2.0f), 3.0f).width, behind.width) << "in two steps";
}

// Against rays that a ball reflects, met off its middle as well, from outside and from inside.
TEST(RayCone, MirrorBallTurnsItAsItTurnsABundle) {
    const double width = 1e-5, radius = 2.0;
    for (const bool isInside : {false, true})
        for (const double spread : {0.0, 1e-5})
            for (const double tilt : {0.0, 0.3, 0.6}) {  // sine of the angle at which it is met
                Bundle bundle = BundleOf(width, spread);
                const Vector center(radius * tilt, 0.0, isInside ? 0.0 : -4.0);
                const double reached =
                    glm::length(MeetSphere({}, bundle.direction[0], center, radius) - bundle.origin[0]);
                for (int i = 0; i < 3; ++i) {
                    Vector& direction = bundle.direction[i];
                    bundle.origin[i] = MeetSphere(bundle.origin[i], direction, center, radius);
                    direction = glm::reflect(direction, glm::normalize(bundle.origin[i] - center));
                }
                const float curvature = float((isInside ? -1.0 : 1.0) / radius);
                const RayCone met = AdvanceCone(MakeCone(float(width), float(spread)), float(reached));
                const RayCone cone = ReflectCone(met, curvature);
                for (const double distance : {0.25, 10.0, 100.0}) {
                    const double expected = WidthAt(bundle, distance);
                    // Between its two foci a tilted bundle is narrower than the mean of both says
                    EXPECT_NEAR(AdvanceCone(cone, float(distance)).width, expected, 0.07 * expected)
                        << (isInside ? "inside" : "outside") << ", spread " << spread << ", tilt " << tilt
                        << ", at " << distance;
                }
            }
}

TEST(RayCone, GlassBallTurnsItAsItTurnsABundle) {
    const double width = 1e-5, radius = 2.0, tilt = 0.1;
    for (const double spread : {0.0, 1e-5}) {
        Bundle bundle = BundleOf(width, spread);
        const Vector center(radius * tilt, 0.0, -4.0);
        RayCone cone = MakeCone(float(width), float(spread));
        for (const double eta : {1.5, 1.0 / 1.5}) {  // into the ball, and out of it
            const bool isOutside = eta > 1.0;
            const Vector from = bundle.origin[0] + 1e-9 * bundle.direction[0];
            const double reached =
                glm::length(MeetSphere(from, bundle.direction[0], center, radius) - bundle.origin[0]);
            for (int i = 0; i < 3; ++i) {
                Vector& direction = bundle.direction[i];
                bundle.origin[i] = MeetSphere(bundle.origin[i] + 1e-9 * direction, direction, center, radius);
                const Vector outward = glm::normalize(bundle.origin[i] - center);
                direction = glm::refract(direction, isOutside ? outward : -outward, 1.0 / eta);
            }
            cone = RefractCone(AdvanceCone(cone, float(reached)), float((isOutside ? 1.0 : -1.0) / radius),
                               float(eta));
            for (const double distance : {0.5, 30.0}) {
                const double expected = WidthAt(bundle, distance);
                EXPECT_NEAR(AdvanceCone(cone, float(distance)).width, expected, 0.05 * expected)
                    << "eta " << eta << ", spread " << spread << ", at " << distance;
            }
        }
    }
}

// The parts that the paths of a lobe stand for have its solid angle together.
TEST(RayCone, RoughLobesWidenItInProportion) {
    const float spread = 0.01f;
    const auto widening = [&](float pdf) { return WidenCone(MakeCone(0.2f, spread), pdf).spread - spread; };
    EXPECT_EQ(WidenCone(MakeCone(0.2f, spread), 1.0f).width, 0.2f) << "not where it is scattered";
    const float lambert = widening(kInvPi);
    EXPECT_NEAR(4.0f * lambert * lambert, 3.14159265f, 1e-4f);
    // The middle of GGX seen from above: D / 4
    const auto facets = [&](float alpha) { return widening(kInvPi / (4.0f * alpha * alpha)); };
    for (const float alpha : {0.01f, 0.05f, 0.2f})
        EXPECT_NEAR(facets(alpha), 1.7724539f * alpha, 1e-3f * alpha);
    // Far off the middle of a lobe a path stands for no more than a hemisphere's part
    EXPECT_NEAR(4.0f * widening(1e-20f) * widening(1e-20f), 6.2831853f, 1e-4f);
    EXPECT_NEAR(widening(0.0f), widening(1e-20f), 1e-6f);
}

TEST(RayCone, CurvatureIsThatOfTheSurfaceOfTheNormals) {
    std::mt19937 generator(3);
    std::normal_distribution<float> normal;
    const auto direction = [&] {
        return normalize(vec3(normal(generator), normal(generator), normal(generator)));
    };
    for (int i = 0; i < 1000; ++i) {
        // The radii are about 1, 2^-40 and 2^40: a room, a grain, a planet's orbit
        const float radius = std::exp2(3.0f * normal(generator) + (i % 3 == 0   ? 0.0f
                                                                   : i % 3 == 1 ? -40.0f
                                                                                : 40.0f));
        const vec3 at = direction();
        vec3 n[3];
        for (vec3& corner : n) corner = normalize(at + 0.3f * direction());
        const vec3 e1 = radius * (n[1] - n[0]), e2 = radius * (n[2] - n[0]);
        if (length(cross(e1, e2)) < 0.01f * radius * radius) continue;
        ASSERT_NEAR(MeanCurvature(e1, e2, n[0], n[1], n[2]) * radius, 1.0f, 1e-3f) << "a ball";
        ASSERT_NEAR(MeanCurvature(e2, e1, n[0], n[2], n[1]) * radius, 1.0f, 1e-3f) << "whatever its winding";
        ASSERT_NEAR(MeanCurvature(e1, e2, -n[0], -n[1], -n[2]) * radius, -1.0f, 1e-3f) << "from within";
        ASSERT_EQ(MeanCurvature(e1, e2, n[0], n[0], n[0]), 0.0f) << "flat";
        ASSERT_EQ(MeanCurvature(e1, 2.0f * e1, n[0], n[1], n[2]), 0.0f) << "a sliver";
    }
    // Along a cylinder it is 0, around it 1 / radius
    const vec3 n0(1.0f, 0.0f, 0.0f), n1 = normalize(vec3(1.0f, 0.02f, 0.0f));
    EXPECT_NEAR(MeanCurvature(5.0f * (n1 - n0), vec3(0.0f, 0.0f, 0.3f), n0, n1, n0), 0.5f / 5.0f, 1e-3f);
}

}  // namespace
}  // namespace raygraph::shading::ray_cone_test
