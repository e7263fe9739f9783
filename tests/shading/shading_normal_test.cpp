// Shading normals are legal for every viewer, and left alone where they are.
#include "core/frame.glsl"

#include <gtest/gtest.h>

#include <random>

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
