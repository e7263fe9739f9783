// Layers over a base: clear coat, sheen and thin films, alone and over each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/shading/gltf_lobe.h"

// The clear coat: what it reflects alone, and what it leaves to the material below.
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

// Sheen: its distribution, what it reflects alone, and what it leaves to the material below.
namespace raygraph::shading::sheen_test {
namespace {

// Sheen over nothing that reflects.
GltfBxDF Sheen(float roughness, vec3 color = vec3(1.0f)) {
    GltfBxDF sheen = GltfLobe(0.5f);
    sheen.baseColor = vec3(0.0f);
    sheen.specular = 0.0f;
    sheen.sheenColor = color;
    sheen.sheenRoughness = roughness;
    return sheen;
}

GltfBxDF Under(const GltfBxDF& sheen, GltfBxDF base) {
    base.sheenColor = sheen.sheenColor;
    base.sheenRoughness = sheen.sheenRoughness;
    return base;
}

TEST(Sheen, ProjectedAreaOfTheFibersIsOne) {
    for (const float alpha : {0.01f, 0.09f, 0.5f, 1.0f}) {
        double sum = 0.0;
        constexpr int kCount = 20'000;
        for (int i = 0; i < kCount; ++i) {
            const double cosine = std::sqrt((i + 0.5) / kCount);  // cos d(cos) is d(cos^2) / 2
            sum += M_PI / kCount * double{SheenD(alpha, static_cast<float>(cosine))};
        }
        EXPECT_NEAR(sum, 1.0, 3e-3) << alpha;
    }
}

// Conty and Kulla's fit at its own supporting values: equal on both sides of cos = 0.5, and 0 facing the fibers.
TEST(Sheen, MaskingIsContinuous) {
    for (const float alpha : {0.05f, 0.3f, 1.0f})
        EXPECT_NEAR(SheenLambda(alpha, 0.4999f), SheenLambda(alpha, 0.5001f),
                    2e-3f * SheenLambda(alpha, 0.5f));
}

TEST(Sheen, SamplesAgreeWithFAndPDF) {
    uint32_t seed = 5000;
    for (const float roughness : {0.2f, 0.5f, 1.0f})
        for (const float cosine : {0.9f, 0.2f}) {
            const vec3 wo = DirectionAt(cosine, 0.8f);
            const GltfBxDF sheen = Sheen(roughness, vec3(0.9f, 0.5f, 0.1f));
            ExpectSamplesAgree(sheen, wo, 1e-4f, 500);
            const test::ChiSquareResult result =
                ChiSquareOfLobe(SeenFrom(sheen, wo), wo, {{PolarGrid{}}}, seed++);
            EXPECT_GT(result.pValue, 1e-4) << roughness << ", cos " << cosine;
        }
}

TEST(Sheen, IsReciprocal) {
    Uniform uniform(13);
    const GltfBxDF sheen = Sheen(0.4f);
    for (int i = 0; i < 300; ++i) {
        vec3 wo = uniform.Direction(), wi = uniform.Direction();
        wo.z = std::max(std::abs(wo.z), 1e-3f);
        wi.z = std::max(std::abs(wi.z), 1e-3f);
        const float forth = f(sheen, wo, wi).x;
        EXPECT_NEAR(f(sheen, wi, wo).x, forth, 1e-4f * (1e-3f + forth));
    }
}

// The base is scaled smoothly by the sheen's albedo, down to 0 where upright fibers are not seen.
TEST(Sheen, IsReciprocalOverADiffuseBase) {
    Uniform uniform(14);
    GltfBxDF lambert = GltfLobe(0.5f);
    lambert.specular = 0.0f;
    for (const float roughness : {0.0f, 0.1f, 0.15f, 0.5f}) {
        const GltfBxDF both = Under(Sheen(roughness), lambert);
        for (int i = 0; i < 300; ++i) {
            vec3 wo = uniform.Direction(), wi = uniform.Direction();
            wo.z = std::max(std::abs(wo.z), 1e-3f);
            wi.z = std::max(std::abs(wi.z), 1e-3f);
            const float forth = f(both, wo, wi).x;
            EXPECT_NEAR(f(both, wi, wo).x, forth, 2e-4f * (1e-3f + forth))
                << roughness << ": " << wo.z << ", " << wi.z;
        }
    }
}

// The table is what the lobe reflects: by quadrature over the directions of the light, which the baker does in
// another way, and never more than comes in.
TEST(Sheen, AlbedoIsThatOfTheTable) {
    for (const float roughness : {0.1f, 0.3f, 0.6f, 1.0f})
        for (const float cosine : {0.05f, 0.2f, 0.5f, 0.95f}) {
            const vec3 wo = DirectionAt(cosine, 0.0f);
            const GltfBxDF sheen = Sheen(roughness);
            double albedo = 0.0;
            constexpr int kHeights = 600, kAngles = 200;
            for (int i = 0; i < kHeights; ++i) {
                const double v = (i + 0.5) / kHeights;
                for (int j = 0; j < kAngles; ++j) {
                    const vec3 wi = DirectionAt(static_cast<float>(v * v),
                                                static_cast<float>(2.0 * M_PI * (j + 0.5) / kAngles));
                    albedo +=
                        double{f(sheen, wo, wi).x} * v * v * 2.0 * v * 2.0 * M_PI / (kHeights * kAngles);
                }
            }
            const float alpha = std::max(roughness * roughness, kMinSheenAlpha);
            const double table = SheenEnergyAt(SpanAt(std::sqrt(alpha), kEnergyAlphaCount), cosine).x;
            EXPECT_NEAR(table, albedo, 0.01 + 0.02 * albedo) << roughness << ", cos " << cosine;
            EXPECT_LT(albedo, 1.005) << roughness << ", cos " << cosine;
        }
}

// A published value: with the masking of the paper, white sheen of roughness 1 seen from the front (Enterprise
// PBR's table and the quadrature of a separate program: 0.164).
TEST(Sheen, OfRoughnessOneReflectsASixthFromTheFront) {
    const double seen = MeasureAlbedo(Sheen(1.0f), vec3(0.0f, 0.0f, 1.0f), 1u << 14u).reflected.x;
    EXPECT_NEAR(seen, 0.1638, 2e-3);
}

TEST(Sheen, WhiteStaysWhiteUnderIt) {
    const std::pair<const char*, GltfBxDF> kBases[] = {
        {"dielectric", GltfLobe(0.3f)}, {"metal", Metal(0.3f)}, {"thin wall", ThinGlass(0.3f)}};
    for (const auto& [name, base] : kBases)
        for (const float roughness : {0.15f, 0.5f, 1.0f})
            for (const float cosine : {0.9f, 0.3f, 0.1f}) {
                const glm::dvec3 sum =
                    MeasureAlbedo(Under(Sheen(roughness), base), DirectionAt(cosine, 0.3f), 1u << 14u).Sum();
                EXPECT_NEAR(sum.x, 1.0, 0.04) << name << ", roughness " << roughness << ", cos " << cosine;
            }
}

// The base is scaled equally in all channels, by the largest one.
TEST(Sheen, DoesNotTintWhatIsBelow) {
    GltfBxDF lambert = GltfLobe(0.5f);
    lambert.specular = 0.0f;
    const vec3 wo = DirectionAt(0.4f, 0.3f);
    const glm::dvec3 alone = MeasureAlbedo(Sheen(0.5f, vec3(0.8f, 0.2f, 0.0f)), wo, 1u << 14u).reflected;
    const glm::dvec3 both =
        MeasureAlbedo(Under(Sheen(0.5f, vec3(0.8f, 0.2f, 0.0f)), lambert), wo, 1u << 14u).reflected;
    const glm::dvec3 below = both - alone;
    EXPECT_NEAR(below.x, below.z, 4e-3);
    EXPECT_NEAR(below.y, below.z, 4e-3);
    EXPECT_NEAR(both.x, 1.0, 0.01);
}

}  // namespace
}  // namespace raygraph::shading::sheen_test

// Layers over layers: what each of them is alone is tested beside it; here is what they leave to each other.
namespace raygraph::shading::layered_test {
namespace {

GltfBxDF Coated(GltfBxDF base, float alpha, float weight = 1.0f) {
    base.clearcoat = weight;
    base.clearcoatRoughness = std::sqrt(alpha);
    base.coatAlpha = alpha;
    return base;
}

GltfBxDF Velvet(GltfBxDF base, float roughness, vec3 color = vec3(1.0f)) {
    base.sheenColor = color;
    base.sheenRoughness = roughness;
    return base;
}

GltfBxDF Sheet(float alpha, float transmission) {
    GltfBxDF sheet = GltfLobe(alpha);
    sheet.isThin = true;
    sheet.diffuseTransmission = transmission;
    sheet.diffuseTransmissionColor = vec3(1.0f);
    return sheet;
}

GltfBxDF Filmed(GltfBxDF base, float ior, float thickness) {
    base.iridescence = 1.0f;
    base.iridescenceIor = ior;
    base.iridescenceThickness = thickness;
    return base;
}

double Schlick(double cosTheta) {
    return 0.04 + 0.96 * std::pow(1.0 - cosTheta, 5.0);
}

// A smooth coat of weight w over a smooth pane: (1 - w F) of what the pane alone sends straight on.
TEST(Layered, CoatOnASmoothPaneTakesWhatItReflects) {
    for (const float weight : {0.5f, 1.0f})
        for (const float cosine : {1.0f, 0.6f, 0.2f}) {
            GltfBxDF pane = ThinGlass(0.0f);
            pane.baseColor = vec3(0.9f, 0.5f, 0.7f);
            const GltfBxDF coated = Coated(pane, 0.0f, weight);
            const vec3 wo = DirectionAt(cosine, 0.4f);
            const double f = Schlick(cosine), under = 1.0 - double{weight} * f;
            const vec3 share = PassThroughWeight(coated, coated, wo);
            const Albedo seen = MeasureAlbedo(coated, wo, 1u << 13u);
            for (int color = 0; color < 3; ++color) {
                const double expected = under * (1.0 - f) * double{pane.baseColor[color]};
                EXPECT_NEAR(share[color], expected, 4e-3) << "weight " << weight << ", cos " << cosine;
                EXPECT_NEAR(seen.transmitted[color], expected, 6e-3) << "weight " << weight;
                EXPECT_NEAR(seen.reflected[color], double{weight} * f + under * f, 6e-3)
                    << "weight " << weight << ", cos " << cosine;
            }
        }
}

// From outside, a coat attenuates refracting glass like other bases; from within, total reflection stays
// total.
TEST(Layered, CoatOnSmoothGlassTakesWhatItReflects) {
    for (const float cosine : {1.0f, 0.6f, 0.2f}) {
        const double f = Schlick(cosine), coat = 0.7 * f;
        const Albedo seen =
            MeasureAlbedo(Coated(Glass(0.0f, 1.5f), 0.0f, 0.7f), DirectionAt(cosine, 0.4f), 1u << 13u);
        EXPECT_NEAR(seen.reflected.x, coat + (1.0 - coat) * f, 6e-3) << "cos " << cosine;
        EXPECT_NEAR(seen.transmitted.x, (1.0 - coat) * (1.0 - f), 6e-3) << "cos " << cosine;
    }
    const Albedo inside =
        MeasureAlbedo(Coated(Glass(0.0f, 1.0f / 1.5f), 0.0f), DirectionAt(0.5f, 0.0f), 1u << 13u);
    EXPECT_NEAR(inside.reflected.x, 1.0, 6e-3);
    EXPECT_EQ(inside.transmitted.x, 0.0);
}

// Walks take the place of the facets below a coat; the coat itself goes by the tables.
TEST(Layered, WhiteUnderACoatStaysWhiteWithWalks) {
    const MultiscatterScope scope(MultiscatterKind::Walk);
    const std::pair<const char*, GltfBxDF> kBases[] = {{"dielectric", GltfLobe(0.6f)},
                                                       {"metal", Metal(0.6f)},
                                                       {"glass", Glass(0.4f, 1.5f)},
                                                       {"thin wall", ThinGlass(0.4f)},
                                                       {"sheet", Sheet(0.5f, 0.6f)}};
    for (const auto& [name, base] : kBases)
        for (const float alpha : {0.0f, 0.3f})
            for (const float cosine : {0.9f, 0.3f}) {
                const double sum =
                    MeasureAlbedo(Coated(base, alpha), DirectionAt(cosine, 0.3f), 1u << 14u).Sum().x;
                EXPECT_NEAR(sum, 1.0, 0.02) << name << ", alpha " << alpha << ", cos " << cosine;
            }
}

// With walks, f of a coated surface is an estimate: its mean is over many, and that of samples must agree.
TEST(Layered, WalksUnderACoatHaveTheAlbedoOfTheirSamples) {
    const MultiscatterScope scope(MultiscatterKind::Walk);
    GltfBxDF lobe = Coated(Metal(0.6f, vec3(0.9f, 0.6f, 0.3f)), 0.2f, 0.8f);
    const vec3 wo = DirectionAt(0.6f, 0.2f);
    const glm::dvec3 sampled = MeasureAlbedo(lobe, wo, 1u << 15u).reflected;
    glm::dvec3 evaluated(0.0);
    constexpr uint kCount = 1u << 16u;
    for (uint i = 0; i < kCount; ++i) {
        Sampler rng = StartPixelSample(uvec2(5u, 9u), i, 13u);
        lobe.seed = MixBits(i + 5u);
        const vec3 wi = SampleCosineHemisphere(Get2D(rng));
        if (wi.z > 0.0f) evaluated += glm::dvec3(f(lobe, wo, wi)) * (M_PI / kCount);
    }
    for (int color = 0; color < 3; ++color)
        EXPECT_NEAR(evaluated[color], sampled[color], 0.015 * sampled[color]) << color;
}

// The coat is on top: of the velvet as it would be alone, it leaves one minus what it reflects.
TEST(Layered, CoatCoversSheen) {
    for (const float roughness : {0.3f, 0.8f})
        for (const float cosine : {0.9f, 0.3f}) {
            GltfBxDF black = GltfLobe(0.5f);
            black.specular = 0.0f;
            black.baseColor = vec3(0.0f);
            const GltfBxDF velvet = Velvet(black, roughness, vec3(0.9f, 0.5f, 0.2f));
            const vec3 wo = DirectionAt(cosine, 0.3f);
            const glm::dvec3 alone = MeasureAlbedo(velvet, wo, 1u << 14u).reflected;
            const glm::dvec3 both = MeasureAlbedo(Coated(velvet, 0.0f, 0.8f), wo, 1u << 14u).reflected;
            const double coat = 0.8 * Schlick(cosine);
            for (int color = 0; color < 3; ++color)
                EXPECT_NEAR(both[color], coat + (1.0 - coat) * alone[color], 6e-3)
                    << "roughness " << roughness << ", cos " << cosine << ", color " << color;
            for (const float alpha : {0.0f, 0.3f}) {
                const GltfBxDF white = Coated(Velvet(GltfLobe(0.4f), roughness), alpha);
                EXPECT_NEAR(MeasureAlbedo(white, wo, 1u << 14u).Sum().x, 1.0, 0.04)
                    << "roughness " << roughness << ", coat of alpha " << alpha << ", cos " << cosine;
            }
        }
}

// A film takes from what gets to a sheet below it as any layer does: white, the whole returns and passes all
// light, and what passes is the factor's share of what the film leaves.
TEST(Layered, FilmOverDiffuseTransmissionLosesNothing) {
    for (const float alpha : {0.0f, 0.4f})
        for (const float thickness : {180.0f, 420.0f})
            for (const float cosine : {0.9f, 0.4f}) {
                const vec3 wo = DirectionAt(cosine, 0.3f);
                GltfBxDF sheet = Filmed(Sheet(alpha, 0.6f), 1.8f, thickness);
                const Albedo seen = MeasureAlbedo(sheet, wo, 1u << 14u);
                sheet.baseColor = vec3(0.0f);
                sheet.diffuseTransmissionColor = vec3(0.0f);
                const glm::dvec3 layer = MeasureAlbedo(sheet, wo, 1u << 14u).reflected;
                const double left = 1.0 - std::max({layer.x, layer.y, layer.z});
                for (int color = 0; color < 3; ++color) {
                    EXPECT_NEAR(seen.transmitted[color], 0.6 * left, 0.02)
                        << "alpha " << alpha << ", " << thickness << " nm, cos " << cosine;
                    EXPECT_LT(seen.Sum()[color], 1.02);
                }
                // The channel that the film reflects most loses nothing
                EXPECT_NEAR(std::max({seen.Sum().x, seen.Sum().y, seen.Sum().z}), 1.0, 0.02)
                    << "alpha " << alpha << ", " << thickness << " nm, cos " << cosine;
            }
}

}  // namespace
}  // namespace raygraph::shading::layered_test

// Materials under a thin film: their lobes, and the energy of the whole.
namespace raygraph::shading::iridescence_test {
namespace {

constexpr vec3 kUp(0.0f, 0.0f, 1.0f);

GltfBxDF Filmed(GltfBxDF base, float ior, float thickness, float weight = 1.0f) {
    base.iridescence = weight;
    base.iridescenceIor = ior;
    base.iridescenceThickness = thickness;
    // The media are in vacuum
    base.outerIor = std::max(1.0f / base.eta, 1.0f);
    return base;
}

struct Base {
    const char* name;
    GltfBxDF (*of)(float alpha);
};

const std::vector<Base> kWhiteBases = {
    {"dielectric", [](float alpha) { return GltfLobe(alpha); }},
    {"metal", [](float alpha) { return Metal(alpha, vec3(1.0f)); }},
    {"gray metal", [](float alpha) { return Metal(alpha, vec3(0.5f)); }},
    {"black metal", [](float alpha) { return Metal(alpha, vec3(0.0f)); }},
    {"glass from outside", [](float alpha) { return Glass(alpha, 1.5f); }},
    {"glass from inside", [](float alpha) { return Glass(alpha, 1.0f / 1.5f); }},
    {"thin wall", [](float alpha) { return ThinGlass(alpha); }}};

TEST(Iridescence, SamplesAgreeWithFAndPDF) {
    uint32_t seed = 6000;
    GltfBxDF thin = Blend(0.4f);
    thin.isThin = true;
    for (const GltfBxDF& base : {GltfLobe(0.4f), Metal(0.4f, vec3(0.2f, 0.5f, 0.9f)), thin, Glass(0.3f, 1.5f),
                                 Glass(0.3f, 1.0f / 1.5f)})
        for (const float cosine : {0.6f}) {
            const vec3 wo = DirectionAt(cosine, 0.8f);
            const Seen seen = SeenFrom(Filmed(base, 1.7f, 420.0f), wo);
            ExpectSamplesAgree(seen, wo, 1e-3f, 500);
            const test::ChiSquareResult result =
                ChiSquareOfLobe(seen, wo, {{PolarGrid{.ringCount = 40}}}, seed++);
            EXPECT_GT(result.pValue, 1e-4) << base.metallic << base.transmission << ", cos " << cosine;
        }
}

// Single scattering is reciprocal, whatever the film.
TEST(Iridescence, FacetsAreReciprocal) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    Uniform uniform(14);
    for (const Base& base : kWhiteBases) {
        GltfBxDF filmed = Filmed(base.of(0.4f), 1.8f, 380.0f);
        filmed.baseColor = min(filmed.baseColor, vec3(filmed.metallic > 0.0f ? 1.0f : 0.0f));
        for (int i = 0; i < 300; ++i) {
            vec3 wo = uniform.Direction(), wi = uniform.Direction();
            wo.z = std::max(std::abs(wo.z), 1e-3f);
            wi.z = std::max(std::abs(wi.z), 1e-3f);
            const vec3 forth = f(filmed, wo, wi);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(f(filmed, wi, wo)[c], forth[c], 2e-4f * (1e-3f + forth[c])) << base.name;
        }
    }
}

// f n^2 is the same both ways through a boundary.
TEST(Iridescence, RefractionIsReciprocal) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    Uniform uniform(15);
    const GltfBxDF outside = Filmed(Glass(0.4f, 1.5f), 1.8f, 380.0f);
    const GltfBxDF inside = Filmed(Glass(0.4f, 1.0f / 1.5f), 1.8f, 380.0f);
    int count = 0;
    for (int i = 0; i < 2000; ++i) {
        const vec3 wo = DirectionAt(0.1f + 0.9f * uniform(), 6.0f * uniform());
        const BSDFSample s = Sample_f(outside, wo, uniform(), uniform.Pair());
        if (s.pdf == 0.0f || s.wi.z > 0.0f) continue;
        ++count;
        const vec3 back = f(inside, vec3(s.wi.x, s.wi.y, -s.wi.z), vec3(wo.x, wo.y, -wo.z));
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(back[c], s.f[c] * 2.25f, 5e-3f * (1e-3f + back[c])) << wo.z << " " << s.wi.z;
    }
    EXPECT_GT(count, 1000);
}

TEST(Iridescence, SmoothGlassReflectsAndTransmitsAllOfEachChannel) {
    for (const bool isThin : {false, true})
        for (const float eta : {1.5f, 1.0f / 1.5f})
            for (const float cosine : {1.0f, 0.8f, 0.3f, 0.05f})
                for (const float thickness : {80.0f, 300.0f, 900.0f}) {
                    GltfBxDF glass = Filmed(Glass(0.0f, eta), 1.9f, thickness);
                    glass.isThin = isThin;
                    const Albedo albedo = MeasureAlbedo(glass, DirectionAt(cosine, 0.4f), 1u << 10u);
                    const glm::dvec3 lost = glm::abs(albedo.Sum() - 1.0);
                    EXPECT_LT(std::max({lost.x, lost.y, lost.z}), 3e-3)
                        << eta << ", cos " << cosine << ", " << thickness << " nm";
                }
}

// Nothing gains energy. Of rough glass the tables return all light within 2 % (1.5 % without a film), and walks
// are estimates.
TEST(Iridescence, WhiteFurnaceNeverGainsEnergy) {
    for (const MultiscatterKind kind : {MultiscatterKind::Lut, MultiscatterKind::Walk}) {
        const MultiscatterScope scope(kind);
        for (const Base& base : kWhiteBases) {
            double most = 0.0;
            for (const float roughness : {0.0f, 0.4f, 1.0f})
                for (const float cosine : {0.95f, 0.25f})
                    for (const float ior : {1.2f, 2.0f})
                        for (const float thickness : {90.0f, 300.0f, 1200.0f}) {
                            const GltfBxDF filmed = Filmed(base.of(roughness * roughness), ior, thickness);
                            const glm::dvec3 sum =
                                MeasureAlbedo(filmed, DirectionAt(cosine, 0.4f), 1u << 10u).Sum();
                            most = std::max({most, sum.x, sum.y, sum.z});
                        }
            const bool isExact = kind == MultiscatterKind::Lut && base.of(0.0f).transmission == 0.0f;
            EXPECT_LT(most, isExact ? 1.01 : 1.025) << base.name;
            const bool isWhite = base.of(0.0f).metallic == 0.0f || base.of(0.0f).baseColor.x == 1.0f;
            EXPECT_GT(most, isWhite ? 0.98 : 0.1) << base.name;
        }
    }
}

// A mean over the channels hides no gain: walks of what absorbs nothing lose nothing either.
TEST(Iridescence, WalksThroughGlassLoseNothing) {
    const MultiscatterScope scope(MultiscatterKind::Walk);
    for (const float eta : {1.5f, 1.0f / 1.5f})
        for (const bool isThin : {false, true}) {
            GltfBxDF filmed = Filmed(Glass(0.36f, eta), 1.7f, 330.0f);
            filmed.isThin = isThin;
            const glm::dvec3 sum = MeasureAlbedo(filmed, DirectionAt(0.6f, 0.4f), 1u << 15u).Sum();
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], 1.0, 6e-3) << eta << ", channel " << c;
        }
}

// The albedo that weights of sampling, later bounces and the base go by, against what the facets reflect.
TEST(Iridescence, TablesTakeAboutTheAlbedoOfTheFacets) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    double worst = 0.0, squares = 0.0;
    int count = 0;
    for (const Base& base : {kWhiteBases[0], kWhiteBases[2], kWhiteBases[3]})
        for (const float roughness : {0.0f, 0.4f, 1.0f})
            for (const float cosine : {0.95f, 0.25f})
                for (const float ior : {1.2f, 2.0f})
                    for (const float thickness : {90.0f, 300.0f, 1200.0f}) {
                        GltfBxDF filmed = Filmed(base.of(roughness * roughness), ior, thickness);
                        const vec3 wo = DirectionAt(cosine, 0.4f);
                        const FacetView view = ViewOf(filmed, wo);
                        const bool isMetal = filmed.metallic > 0.0f;
                        const vec3 claimed =
                            isMetal ? Reflected(PlacedLobe<ConductorBxDF>(filmed, wo), view).albedo
                                    : Reflected(PlacedLobe<DielectricLayerBxDF>(filmed, wo), view).albedo;
                        if (!isMetal) filmed.baseColor = vec3(0.0f);
                        const glm::dvec3 seen = MeasureAlbedo(filmed, wo, 1u << 12u).Sum();
                        for (int c = 0; c < 3; ++c) {
                            const double error = std::abs(seen[c] - double{claimed[c]});
                            worst = std::max(worst, error);
                            squares += error * error;
                            ++count;
                        }
                    }
    EXPECT_LT(worst, 0.05);
    EXPECT_LT(std::sqrt(squares / count), 0.008);
}

// The base of a white dielectric gets what the channel that is reflected most leaves, and the whole has the
// colors of the film.
TEST(Iridescence, BaseIsNotTinted) {
    const vec3 wo = DirectionAt(0.8f, 0.3f);
    const GltfBxDF filmed = Filmed(GltfLobe(0.0f), 1.8f, 340.0f);
    const vec3 white = f(filmed, wo, DirectionAt(0.7f, 2.0f));
    EXPECT_EQ(white, vec3(white.x));
    GltfBxDF black = filmed;
    black.baseColor = vec3(0.0f);
    const glm::dvec3 film = MeasureAlbedo(black, wo, 1u << 10u).Sum();
    const glm::dvec3 whole = MeasureAlbedo(filmed, wo, 1u << 14u).Sum();
    EXPECT_GT(std::max({film.x, film.y, film.z}) - std::min({film.x, film.y, film.z}), 0.03);
    EXPECT_NEAR(std::max({whole.x, whole.y, whole.z}), 1.0, 5e-3);
    EXPECT_NEAR(whole.x - whole.z, film.x - film.z, 5e-3);
}

// The medium around a surface is known by its index: a film in water has an index relative to water.
TEST(Iridescence, FilmIsRelativeToTheMediumAround) {
    SurfaceMaterial material{};
    material.ior = 1.5f;
    material.iridescence = 1.0f;
    material.iridescenceIor = 1.33f;
    material.iridescenceThickness = 300.0f;
    SurfaceInteraction surface{};
    surface.material = material;
    surface.isFront = true;
    const Frame frame = FrameFromZ(kUp);
    const auto film = [&](float eta) {
        return DielectricFresnel(surface.material, SettingOf(surface, frame, eta, 0.0f, 1u)).film;
    };
    EXPECT_FLOAT_EQ(film(1.5f).eta, 1.33f) << "in vacuum";
    EXPECT_FLOAT_EQ(film(1.5f / 1.33f).eta, 1.0f) << "in water";
    EXPECT_FLOAT_EQ(film(1.5f).path, 2.0f * 1.33f * 300.0f);
    surface.isFront = false;
    EXPECT_FLOAT_EQ(film(1.5f).eta, 1.33f) << "the back of what is no volume";
    surface.material.flags = kMaterialVolume;
    EXPECT_FLOAT_EQ(film(1.0f / 1.5f).eta, 1.33f) << "from within glass in vacuum";
    EXPECT_FLOAT_EQ(film(1.33f / 1.5f).eta, 1.0f) << "from within glass in water";
    EXPECT_FLOAT_EQ(film(2.0f / 1.5f).eta, 1.33f / 1.5f) << "from within a bubble of lower index";
}

}  // namespace
}  // namespace raygraph::shading::iridescence_test
