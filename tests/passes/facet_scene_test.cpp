// Triangles of placed meshes, traced on the host.
#include "renderer/bvh/facet_scene.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "tests/support/triangle_soup.h"

namespace raygraph::facet_scene_test {
namespace {

FacetScene FacetsOf(const BvhScene& scene, bool isBackCulled = false) {
    std::vector<std::vector<Facet>> meshes;
    for (const BvhMesh& mesh : scene.meshes) {
        std::vector<Facet>& facets = meshes.emplace_back();
        const auto corner = [&](size_t i) { return mesh.positions[mesh.indices[i]]; };
        for (size_t i = 0; i < mesh.indices.size(); i += 3)
            facets.push_back({corner(i), corner(i + 1), corner(i + 2), isBackCulled});
    }
    return {std::move(meshes), scene.instances};
}

TEST(FacetScene, FindsTheNearestOfAllTriangles) {
    const BvhScene scene = testing::InstancedTriangleSoup();
    const FacetScene facets = FacetsOf(scene);
    uint32_t hits = 0;
    const std::vector<gpu::BenchRay> rays = testing::RandomRays(2000, 7);
    for (const gpu::BenchRay& ray : rays) {
        const ExactHit exact = TraceExactly(scene, ray);
        if (exact.isAmbiguous) continue;
        const std::optional<FacetHit> hit = facets.Trace(ray.origin, ray.direction);
        EXPECT_EQ(facets.IsOccluded(ray.origin, ray.direction, ray.tMax), exact.t >= 0.0);
        ASSERT_EQ(hit.has_value(), exact.t >= 0.0);
        if (!hit) continue;
        ++hits;
        EXPECT_NEAR(double{hit->t}, exact.t, 1e-4 * exact.t);
        EXPECT_EQ(hit->instance, exact.instance);
        EXPECT_EQ(hit->facet, exact.primitive);
        // The normal is perpendicular to the triangle where it is placed, and on the ray's side
        const Facet& facet = facets.FacetsOf(scene.instances[hit->instance].mesh)[hit->facet];
        const glm::mat3 linear(scene.instances[hit->instance].objectToWorld);
        for (const glm::vec3& edge : {facet.p1 - facet.p0, facet.p2 - facet.p0})
            EXPECT_NEAR(glm::dot(hit->normal, glm::normalize(linear * edge)), 0.0f, 1e-3f);
        EXPECT_NEAR(glm::length(hit->normal), 1.0f, 1e-5f);
        EXPECT_LE(glm::dot(hit->normal, ray.direction), 0.0f);
    }
    EXPECT_GT(hits, rays.size() / 4);
    EXPECT_LT(hits, rays.size());
}

TEST(FacetScene, RaysPassThroughCulledBacksAndAMirrorKeepsTheFront) {
    const BvhScene quad{
        {{.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, .indices = {0, 1, 2, 0, 2, 3}}},
        {{}}};
    BvhScene mirrored = quad;
    mirrored.instances[0].objectToWorld = glm::mat4x3(glm::scale(glm::mat4(1.0f), {-2.0f, 1.0f, 1.0f}));
    const glm::vec3 above(0.3f, 0.2f, 1.0f), below(0.3f, 0.2f, -1.0f), up(0.0f, 0.0f, 1.0f);
    for (const BvhScene& scene : {quad, mirrored}) {
        const FacetScene culled = FacetsOf(scene, true);
        EXPECT_TRUE(culled.Trace(above, -up));
        EXPECT_FALSE(culled.Trace(below, up));
        EXPECT_FALSE(culled.IsOccluded(below, up, 10.0f));
        EXPECT_TRUE(FacetsOf(scene).Trace(below, up));
    }
}

TEST(FacetScene, ATestDecidesWhichRaysPassThrough) {
    // Three triangles one behind the other, of which the first two are tested
    std::vector<Facet> facets;
    for (const float z : {2.0f, 1.0f, 0.0f}) facets.push_back({{-1, -1, z}, {3, -1, z}, {-1, 3, z}});
    facets[0].isTested = facets[1].isTested = true;
    const auto isThere = [](uint32_t, uint32_t facet, const glm::vec2& barycentrics) {
        return facet == 1 && barycentrics.x > 0.3f && barycentrics.y < 0.3f;
    };
    const FacetScene scene({facets}, {{}}, 1, isThere);
    const auto hit = [&](float x, float y) { return scene.Trace({x, y, 5}, {0, 0, -1}); };
    ASSERT_TRUE(hit(0.5f, -0.5f));
    EXPECT_EQ(hit(0.5f, -0.5f)->facet, 1u);
    EXPECT_NEAR(hit(0.5f, -0.5f)->barycentrics.x, 0.375f, 1e-6f);
    EXPECT_NEAR(hit(0.5f, -0.5f)->barycentrics.y, 0.125f, 1e-6f);
    ASSERT_TRUE(hit(0.0f, 0.5f));
    EXPECT_EQ(hit(0.0f, 0.5f)->facet, 2u);
    EXPECT_TRUE(scene.IsOccluded({0.5f, -0.5f, 5}, {0, 0, -1}, 4.5f));
    EXPECT_FALSE(scene.IsOccluded({0.0f, 0.5f, 5}, {0, 0, -1}, 4.5f));
    EXPECT_EQ(FacetScene({facets}, {{}}).Trace({0.5f, 0.5f, 5}, {0, 0, -1})->facet, 0u);
}

TEST(FacetScene, WhatHasNoInverseOrNoFacetsIsNotHit) {
    const std::vector<Facet> triangle{{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}};
    const glm::mat4x3 flat(glm::scale(glm::mat4(1.0f), {1.0f, 0.0f, 1.0f}));
    const FacetScene scene({triangle, {}}, {{0, flat}, {1, glm::mat4x3(1.0f)}});
    EXPECT_FALSE(scene.Trace({0, 0, 1}, {0, 0, -1}));
    EXPECT_FALSE(FacetScene({}, {}).Trace({0, 0, 1}, {0, 0, -1}));
}

}  // namespace
}  // namespace raygraph::facet_scene_test
