// Layers over layers: what each of them is alone is tested beside it; here is what they leave to each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/shading/gltf_lobe.h"

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
