// The clear coat: what it reflects alone, and what it leaves to the material below.
#include "tests/shading/gltf_lobe.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace raygraph::shading::clearcoat_test {
namespace {

constexpr vec3 kUp(0.0f, 0.0f, 1.0f);

// A coat of this roughness over nothing that reflects.
GltfBxDF Coat(float alpha, float weight = 1.0f, vec3 normal = kUp) {
    GltfBxDF coat = GltfLobe(0.5f);
    coat.baseColor = vec3(0.0f);
    coat.specular = 0.0f;
    coat.clearcoat = weight;
    coat.clearcoatRoughness = std::sqrt(alpha);
    coat.coatAlpha = alpha;
    coat.coatNormal = normal;
    return coat;
}

GltfBxDF Coated(GltfBxDF base, const GltfBxDF& coat) {
    base.clearcoat = coat.clearcoat;
    base.clearcoatRoughness = coat.clearcoatRoughness;
    base.coatAlpha = coat.coatAlpha;
    base.coatNormal = coat.coatNormal;
    return base;
}

float Schlick(float cosTheta) {
    return 0.04f + 0.96f * std::pow(1.0f - cosTheta, 5.0f);
}

const vec3 kTilted = normalize(vec3(0.3f, -0.2f, 1.0f));

TEST(Clearcoat, SampledDirectionsFollowPDF) {
    uint32_t seed = 4000;
    for (const vec3 normal : {kUp, kTilted})
        for (const float alpha : {0.1f, 0.4f, 1.0f})
            for (const float cosine : {0.9f, 0.3f}) {
                const vec3 wo = DirectionAt(cosine, 0.8f);
                const GltfBxDF coat = Coat(alpha, 0.7f, normal);
                const PolarGrid grid =
                    alpha < 0.2f ? PolarGrid::About(Reflect(wo, normal), alpha) : PolarGrid{};
                const test::ChiSquareResult result =
                    ChiSquareOfLobe(SeenFrom(coat, wo), wo, {{grid}}, seed++);
                EXPECT_GT(result.pValue, 1e-4)
                    << "alpha " << alpha << ", cos " << cosine << ", tilt " << normal.x;
                ExpectSamplesAgree(coat, wo, 2e-4f, 500);
            }
}

TEST(Clearcoat, IsReciprocalAlongItsOwnNormal) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    Uniform uniform(12);
    const GltfBxDF coat = Coat(0.3f);
    for (int i = 0; i < 300; ++i) {
        vec3 wo = uniform.Direction(), wi = uniform.Direction();
        wo.z = std::abs(wo.z);
        wi.z = std::abs(wi.z);
        const float forth = f(coat, wo, wi).x;
        EXPECT_NEAR(f(coat, wi, wo).x, forth, 1e-4f * (1e-3f + forth));
    }
}

// A smooth coat is Fresnel's mirror at the coat's own normal.
TEST(Clearcoat, SmoothOneReflectsByFresnelAboutItsNormal) {
    for (const vec3 normal : {kUp, kTilted})
        for (const float cosine : {1.0f, 0.6f, 0.3f}) {
            const vec3 wo = DirectionAt(cosine, 5.5f);
            const GltfBxDF coat = Coat(0.0f, 0.8f, normal);
            EXPECT_EQ(Flags(coat), kBxDFReflection | kBxDFSpecular);
            const BSDFSample s = Sample_f(coat, wo, 0.5f, vec2(0.3f, 0.6f));
            ASSERT_TRUE(IsSpecular(s.flags));
            EXPECT_LT(distance(s.wi, Reflect(wo, normal)), 1e-5f);
            const float expected = 0.8f * Schlick(dot(wo, normal));
            EXPECT_NEAR(s.f.x * s.wi.z / s.pdf, expected, 5e-3f * expected);
        }
}

// w F + (1 - w F) albedo, whatever the weight: the base gets back what the coat would shade twice.
TEST(Clearcoat, OverLambertTheAlbedoIsTheClosedForm) {
    for (const float weight : {0.0f, 0.5f, 1.0f})
        for (const float albedo : {1.0f, 0.5f})
            for (const float cosine : {1.0f, 0.7f, 0.25f}) {
                GltfBxDF lambert = GltfLobe(0.5f);
                lambert.specular = 0.0f;
                lambert.baseColor = vec3(albedo);
                const Albedo seen =
                    MeasureAlbedo(Coated(lambert, Coat(0.0f, weight)), DirectionAt(cosine, 0.3f), 1u << 15u);
                const double coat = weight * Schlick(cosine);
                EXPECT_NEAR(seen.reflected.x, coat + (1.0 - coat) * albedo, 4e-3)
                    << "weight " << weight << ", albedo " << albedo << ", cos " << cosine;
            }
}

TEST(Clearcoat, WhiteStaysWhiteUnderAnyCoat) {
    GltfBxDF thin = ThinGlass(0.3f);
    const std::pair<const char*, GltfBxDF> kBases[] = {{"dielectric", GltfLobe(0.3f)},
                                                       {"metal", Metal(0.3f)},
                                                       {"smooth metal", Metal(0.0f)},
                                                       {"thin wall", thin}};
    for (const auto& [name, base] : kBases)
        for (const float alpha : {0.0f, 0.2f, 0.8f})
            for (const float cosine : {0.9f, 0.3f}) {
                const glm::dvec3 sum =
                    MeasureAlbedo(Coated(base, Coat(alpha)), DirectionAt(cosine, 0.3f), 1u << 14u).Sum();
                EXPECT_NEAR(sum.x, 1.0, 0.02) << name << ", alpha " << alpha << ", cos " << cosine;
            }
}

// With another normal than the base's the two no longer fit exactly, but energy is not gained.
TEST(Clearcoat, TiltedOnesDoNotGainEnergy) {
    for (const float tilt : {0.1f, 0.4f})
        for (const float alpha : {0.0f, 0.3f})
            for (const float cosine : {0.95f, 0.6f, 0.3f})
                for (const float phi : {0.0f, 1.6f, 3.1f}) {
                    const vec3 normal = normalize(vec3(tilt, 0.0f, 1.0f));
                    const vec3 wo = DirectionAt(cosine, phi);
                    if (dot(wo, normal) < 0.1f) continue;
                    const double sum =
                        MeasureAlbedo(Coated(GltfLobe(0.4f), Coat(alpha, 1.0f, normal)), wo, 1u << 14u)
                            .Sum()
                            .x;
                    EXPECT_LT(sum, 1.03) << "tilt " << tilt << ", alpha " << alpha << ", cos " << cosine;
                    // The coat's reflection may go below the surface
                    const float lost = alpha == 0.0f ? Schlick(dot(wo, normal)) : 0.2f;
                    EXPECT_GT(sum, 0.95 - lost)
                        << "tilt " << tilt << ", alpha " << alpha << ", cos " << cosine;
                }
}

// Two mirrors with normals of their own, each with its own direction and nothing of the other's.
TEST(Clearcoat, SmoothCoatOverAMirrorHasTwoReflections) {
    const vec3 wo = DirectionAt(0.8f, 0.5f);
    const GltfBxDF both = Coated(Metal(0.0f, vec3(0.9f)), Coat(0.0f, 1.0f, kTilted));
    glm::dvec2 weights(0.0);  // weights of the coat's direction and the base's
    constexpr int kCount = 20'000;
    for (int i = 0; i < kCount; ++i) {
        const BSDFSample s = Sample_f(both, wo, (float(i) + 0.5f) / kCount, vec2(0.5f));
        ASSERT_GT(s.pdf, 0.0f);
        const bool isCoat = distance(s.wi, Reflect(wo, kTilted)) < 1e-4f;
        EXPECT_TRUE(isCoat || distance(s.wi, Reflect(wo, kUp)) < 1e-4f);
        weights[isCoat ? 0 : 1] += double{s.f.x * s.wi.z / s.pdf} / kCount;
    }
    const float coat = Schlick(dot(wo, kTilted));
    EXPECT_NEAR(weights.x, coat, 3e-3);
    EXPECT_NEAR(weights.y, (1.0 - coat) * (0.9 + 0.1 * std::pow(1.0 - 0.8, 5.0)), 5e-3);
}

// A lamp under a coat: the share that the coat does not reflect.
TEST(Clearcoat, PassesWhatItDoesNotReflect) {
    for (const float cosine : {1.0f, 0.5f, 0.1f}) {
        EXPECT_NEAR(ClearcoatTransmittance(0.6f, 0.0f, cosine), 1.0f - 0.6f * Schlick(cosine), 2e-3f);
        for (const float roughness : {0.3f, 0.9f}) {
            const Albedo coat =
                MeasureAlbedo(Coat(roughness * roughness, 0.6f), DirectionAt(cosine, 0.0f), 1u << 14u);
            EXPECT_NEAR(ClearcoatTransmittance(0.6f, roughness, cosine), 1.0 - coat.reflected.x, 6e-3)
                << roughness << ", cos " << cosine;
        }
    }
    EXPECT_EQ(ClearcoatTransmittance(0.0f, 0.5f, 0.5f), 1.0f);
}

}  // namespace
}  // namespace raygraph::shading::clearcoat_test
