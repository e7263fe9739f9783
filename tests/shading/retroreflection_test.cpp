// Facets that reflect light back: the reflection of a viewer mirrored about the normal, and nothing else.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/shading/gltf_lobe.h"

namespace raygraph::shading::retroreflection_test {
namespace {

GltfBxDF Back(GltfBxDF lobe, float share) {
    lobe.retroreflection = share;
    return lobe;
}

GltfBxDF Brushed() {
    GltfBxDF lobe = Metal(0.3f, vec3(1.0f, 0.7f, 0.3f));
    lobe.alpha.x = 0.7f;
    return lobe;
}

GltfBxDF BlackLayer(float alpha) {
    GltfBxDF lobe = GltfLobe(alpha);
    lobe.baseColor = vec3(0.0f);
    return lobe;
}

struct Surface {
    const char* name;
    GltfBxDF lobe;
};
const Surface kSurfaces[] = {{"metal", Metal(0.3f, vec3(1.0f, 0.7f, 0.3f))},
                             {"brushed metal", Brushed()},
                             {"layer", BlackLayer(0.4f)},
                             {"plastic", GltfLobe(0.5f)},
                             {"glass", Glass(0.4f, 1.5f)},
                             {"glass from within", Glass(0.4f, 1.0f / 1.5f)},
                             {"thin wall", ThinGlass(0.4f)},
                             {"all of it", Blend(0.5f)}};

vec3 AboveOf(Uniform& uniform) {
    vec3 w = uniform.Direction();
    w.z = std::max(std::abs(w.z), 0.02f);
    return normalize(w);
}

}  // namespace

TEST(Retroreflection, SampledDirectionsFollowPDF) {
    uint32_t seed = 6100;
    for (const Surface& surface : kSurfaces)
        for (const float share : {0.4f, 1.0f}) {
            if (share == 1.0f && surface.lobe.transmission == 0.0f) continue;
            const GltfBxDF lobe = Back(surface.lobe, share);
            const vec3 wo = DirectionAt(0.55f, 0.8f);
            const test::ChiSquareResult result =
                ChiSquareOfLobe(SeenFrom(lobe, wo), wo, {{PolarGrid{}}}, seed++);
            EXPECT_GT(result.degreesOfFreedom, 20) << surface.name;
            EXPECT_GT(result.pValue, 1e-4) << surface.name << ", share " << share;
            ExpectSamplesAgree(lobe, wo, 3e-4f, 500);
        }
}

// By definition, a fraction of the reflection to a mirrored viewer is added. The transmission does not
// change.
TEST(Retroreflection, IsTheReflectionForAMirroredViewer) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    Uniform uniform(5);
    for (const Surface& surface : kSurfaces) {
        if (surface.name == std::string("plastic") || surface.name == std::string("all of it")) continue;
        for (int i = 0; i < 200; ++i) {
            const vec3 wo = AboveOf(uniform), wi = AboveOf(uniform), below = -AboveOf(uniform);
            const vec3 ahead = f(surface.lobe, wo, wi), back = f(surface.lobe, Mirrored(wo), wi);
            const vec3 seen = f(Back(surface.lobe, 0.3f), wo, wi);
            for (int color = 0; color < 3; ++color)
                EXPECT_NEAR(seen[color], 0.7f * ahead[color] + 0.3f * back[color],
                            1e-4f * (1e-3f + seen[color]))
                    << surface.name;
            EXPECT_EQ(f(Back(surface.lobe, 0.3f), wo, below), f(surface.lobe, wo, below)) << surface.name;
        }
    }
}

TEST(Retroreflection, IsReciprocal) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    Uniform uniform(11);
    for (const Surface& surface : kSurfaces) {
        const GltfBxDF lobe = Back(surface.lobe, 0.6f);
        for (int i = 0; i < 200; ++i) {
            const vec3 wo = AboveOf(uniform), wi = AboveOf(uniform);
            const float forth = f(lobe, wo, wi).x;
            EXPECT_NEAR(f(lobe, wi, wo).x, forth, 2e-4f * (1e-3f + forth)) << surface.name;
        }
    }
}

// The reflection changes in direction, not in amount: white stays white.
TEST(Retroreflection, ReflectsAsMuchAsAhead) {
    for (const MultiscatterKind kind : {MultiscatterKind::Lut, MultiscatterKind::Walk}) {
        const MultiscatterScope scope(kind);
        for (const Surface& surface : kSurfaces)
            for (const float cosine : {0.9f, 0.3f}) {
                const vec3 wo = DirectionAt(cosine, 0.3f);
                const Albedo ahead = MeasureAlbedo(surface.lobe, wo, 1u << 13u);
                const Albedo back = MeasureAlbedo(Back(surface.lobe, 0.7f), wo, 1u << 13u);
                for (int color = 0; color < 3; ++color) {
                    EXPECT_NEAR(back.reflected[color], ahead.reflected[color], 0.02)
                        << surface.name << ", cos " << cosine << ", kind " << int(kind);
                    EXPECT_NEAR(back.transmitted[color], ahead.transmitted[color], 0.02)
                        << surface.name << ", cos " << cosine << ", kind " << int(kind);
                }
            }
        EXPECT_NEAR(MeasureAlbedo(Back(Metal(0.6f), 1.0f), DirectionAt(0.4f, 1.0f), 1u << 13u).Sum().x, 1.0,
                    0.015);
    }
}

// A smooth surface has two reflections, each with its own share of Fresnel's.
TEST(Retroreflection, SmoothOneReflectsAheadAndBack) {
    const vec3 wo = DirectionAt(0.6f, 0.5f);
    for (const GltfBxDF& lobe : {Back(Metal(0.0f, vec3(0.9f)), 0.25f), Back(ThinGlass(0.0f), 0.25f)}) {
        glm::dvec3 weights(0.0);  // ahead, back, through
        constexpr int kCount = 40'000;
        for (int i = 0; i < kCount; ++i) {
            const BSDFSample s = Sample_f(lobe, wo, (float(i) + 0.5f) / kCount, vec2(0.5f));
            ASSERT_GT(s.pdf, 0.0f);
            ASSERT_TRUE(IsSpecular(s.flags));
            const int way = s.wi.z < 0.0f ? 2 : distance(s.wi, wo) < 1e-5f ? 1 : 0;
            ASSERT_TRUE(way != 0 || distance(s.wi, Mirrored(wo)) < 1e-5f);
            weights[way] += double{s.f.x * std::abs(s.wi.z) / s.pdf} / kCount;
        }
        const double f0 = lobe.metallic > 0.0f ? 0.9 : 0.04;
        const double reflected = f0 + (1.0 - f0) * std::pow(1.0 - 0.6, 5.0);
        EXPECT_NEAR(weights.x, 0.75 * reflected, 2e-3);
        EXPECT_NEAR(weights.y, 0.25 * reflected, 2e-3);
        EXPECT_NEAR(weights.z, lobe.metallic > 0.0f ? 0.0 : 1.0 - reflected, 5e-3);
    }
}

TEST(Retroreflection, CoatAndSheenReflectAsBefore) {
    Uniform uniform(3);
    GltfBxDF coated = GltfLobe(0.5f);
    coated.specular = 0.0f;
    coated.clearcoat = 0.8f;
    coated.clearcoatRoughness = 0.4f;
    coated.coatAlpha = 0.16f;
    GltfBxDF velvet = GltfLobe(0.6f);
    velvet.specular = 0.0f;
    velvet.sheenColor = vec3(0.4f, 0.2f, 0.1f);
    velvet.sheenRoughness = 0.5f;
    for (const GltfBxDF& lobe : {coated, velvet})
        for (int i = 0; i < 50; ++i) {
            const vec3 wo = AboveOf(uniform), wi = AboveOf(uniform);
            EXPECT_NEAR(f(Back(lobe, 1.0f), wo, wi).x, f(lobe, wo, wi).x, 1e-6f);
        }
}

}  // namespace raygraph::shading::retroreflection_test
