// Diffuse transmission: what passes to the other side of a surface, under the layers that are on both sides.
#include "tests/shading/gltf_lobe.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace raygraph::shading::diffuse_transmission_test {
namespace {

// Makes a material without a layer: Lambert's two lobes alone.
GltfBxDF Paper(float transmission, vec3 color = vec3(1.0f), vec3 passed = vec3(1.0f)) {
    GltfBxDF paper = GltfLobe(0.3f);
    paper.specular = 0.0f;
    paper.isThin = true;
    paper.baseColor = color;
    paper.diffuseTransmission = transmission;
    paper.diffuseTransmissionColor = passed;
    return paper;
}

// Under the layer of its dielectric, of this roughness.
GltfBxDF Leaf(float alpha, float transmission, vec3 color = vec3(1.0f), vec3 passed = vec3(1.0f)) {
    GltfBxDF leaf = Paper(transmission, color, passed);
    leaf.specular = 1.0f;
    leaf.alpha = vec2(alpha);
    return leaf;
}

GltfBxDF Coated(GltfBxDF sheet, float roughness, vec3 normal = vec3(0.0f, 0.0f, 1.0f)) {
    sheet.clearcoat = 0.8f;
    sheet.clearcoatRoughness = roughness;
    sheet.coatAlpha = roughness * roughness;
    sheet.coatNormal = normal;
    return sheet;
}

GltfBxDF Velvet(GltfBxDF sheet, float roughness) {
    sheet.sheenColor = vec3(0.9f);
    sheet.sheenRoughness = roughness;
    return sheet;
}

// The boundary of a medium of index 1.5, from outside or from within.
GltfBxDF Bounding(GltfBxDF sheet, bool isInside) {
    sheet.isThin = false;
    sheet.eta = isInside ? 1.0f / 1.5f : 1.5f;
    return sheet;
}

// Returns the sheet for a viewer on the other side, in a frame mirrored at the surface.
GltfBxDF TurnedOver(GltfBxDF sheet) {
    if (!sheet.isThin) sheet.eta = 1.0f / sheet.eta;
    sheet.coatNormal = vec3(-sheet.coatNormal.x, -sheet.coatNormal.y, sheet.coatNormal.z);
    return sheet;
}

vec3 Mirrored(vec3 w) {
    return {w.x, w.y, -w.z};
}

struct Case {
    std::string name;
    GltfBxDF sheet;
};

const vec3 kTilted = normalize(vec3(0.3f, -0.2f, 1.0f));

std::vector<Case> WhiteOnes() {
    return {{"paper", Paper(0.4f)},
            {"all of it", Paper(1.0f)},
            {"smooth leaf", Leaf(0.0f, 0.5f)},
            {"leaf", Leaf(0.3f, 0.7f)},
            {"rough leaf", Leaf(1.0f, 1.0f)},
            {"smoothly coated", Coated(Leaf(0.5f, 0.6f), 0.0f)},
            {"coated", Coated(Leaf(0.2f, 0.6f), 0.5f)},
            {"velvet", Velvet(Leaf(0.5f, 0.6f), 0.5f)},
            {"coated velvet", Coated(Velvet(Paper(0.5f), 0.7f), 0.3f)},
            {"into a medium", Bounding(Leaf(0.3f, 0.7f), false)},
            {"out of a medium", Bounding(Leaf(0.3f, 0.7f), true)}};
}

TEST(DiffuseTransmission, OfPaperIsLambertsOnBothSides) {
    const vec3 color(0.8f, 0.5f, 0.2f), passed(0.1f, 0.9f, 0.4f);
    const GltfBxDF paper = Paper(0.3f, color, passed);
    Uniform uniform(20);
    for (int i = 0; i < 100; ++i) {
        vec3 wo = uniform.Direction();
        wo.z = std::abs(wo.z);
        const vec3 wi = uniform.Direction();
        const vec3 expected = (wi.z > 0.0f ? 0.7f * color : 0.3f * passed) * kInvPi;
        EXPECT_LT(distance(f(paper, wo, wi), expected), 1e-6f) << wo.z << ", " << wi.z;
    }
}

TEST(DiffuseTransmission, SampledDirectionsFollowPDFOverTheSphere) {
    uint32_t seed = 6000;
    const vec3 color(0.8f, 0.5f, 0.2f), passed(0.1f, 0.9f, 0.4f);
    GltfBxDF mixed = Leaf(0.4f, 0.6f, color, passed);
    mixed.metallic = 0.3f;
    mixed.transmission = 0.5f;
    for (const Case& test :
         {Case{"paper", Paper(0.3f, color, passed)}, Case{"leaf", Leaf(0.3f, 0.7f, color, passed)},
          Case{"coated", Coated(Leaf(0.5f, 0.6f, color, passed), 0.6f, kTilted)},
          Case{"velvet", Velvet(Leaf(0.5f, 0.6f, color, passed), 0.5f)}, Case{"with metal and glass", mixed},
          Case{"into a medium", Bounding(Leaf(0.4f, 0.7f, color, passed), false)}})
        for (const float cosine : {0.9f, 0.3f}) {
            const vec3 wo = DirectionAt(cosine, 0.8f);
            const test::ChiSquareResult result =
                ChiSquareOfLobe(SeenFrom(test.sheet, wo), wo, {{PolarGrid{}}}, seed++);
            EXPECT_GT(result.pValue, 1e-4) << test.name << ", cos " << cosine;
            ExpectSamplesAgree(test.sheet, wo, 2e-4f, 1000);
        }
}

// Only diffuse lobes reach the other side here, and those are reciprocal under layers that are on both sides.
TEST(DiffuseTransmission, IsReciprocalThroughEveryLayer) {
    std::vector<Case> cases = WhiteOnes();
    cases.push_back({"tilted coat", Coated(Leaf(0.3f, 0.6f), 0.4f, kTilted)});
    Uniform uniform(21);
    for (const Case& test : cases)
        for (int i = 0; i < 200; ++i) {
            vec3 wo = uniform.Direction(), wi = uniform.Direction();
            wo.z = std::max(std::abs(wo.z), 1e-3f);
            wi.z = -std::max(std::abs(wi.z), 1e-3f);
            // A coat whose normal is turned away from one of them is another matter
            if (dot(wo, test.sheet.coatNormal) < 0.01f || dot(wi, test.sheet.coatNormal) > -0.01f) continue;
            const float forth = f(test.sheet, wo, wi).x;
            const float back = f(TurnedOver(test.sheet), Mirrored(wi), Mirrored(wo)).x;
            // Light of two media: f n^2 is what both directions share
            const float scaled = forth * (test.sheet.isThin ? 1.0f : Sqr(test.sheet.eta));
            EXPECT_NEAR(back, scaled, 2e-4f * (1e-3f + scaled)) << test.name << ": " << wo.z << ", " << wi.z;
        }
}

TEST(DiffuseTransmission, WhiteSheetsReturnAndPassAllLight) {
    std::vector<Case> cases = WhiteOnes();
    cases.push_back({"half of it glass", Leaf(0.3f, 0.6f)});
    cases.back().sheet.transmission = 0.5f;
    for (const Case& test : cases)
        for (const float cosine : {1.0f, 0.7f, 0.2f}) {
            const Albedo albedo = MeasureAlbedo(test.sheet, DirectionAt(cosine, 0.3f), 1u << 14u);
            EXPECT_NEAR(albedo.Sum().x, 1.0, 0.02) << test.name << ", cos " << cosine;
            EXPECT_GT(albedo.transmitted.x, 0.02) << test.name << ", cos " << cosine;
        }
}

// Light that the layers do not transmit is missing on both sides: above a black base, the transmitted
// fraction of all light that is not reflected is the factor.
TEST(DiffuseTransmission, ItsShareIsOfWhatTheLayersPass) {
    for (const float transmission : {0.25f, 1.0f})
        for (Case test : WhiteOnes())
            for (const float cosine : {0.9f, 0.2f}) {
                test.sheet.diffuseTransmission = transmission;
                const vec3 wo = DirectionAt(cosine, 0.3f);
                const double passed = MeasureAlbedo(test.sheet, wo, 1u << 14u).transmitted.x;
                test.sheet.baseColor = vec3(0.0f);
                const double above = MeasureAlbedo(test.sheet, wo, 1u << 14u).reflected.x;
                // From within a medium, only 1 / n^2 of that gets out; the rest comes back
                const double out =
                    test.sheet.isThin ? 1.0 : std::min(1.0, std::pow(double{test.sheet.eta}, 2.0));
                const double below = (1.0 - above) / (1.0 - double{transmission} * (1.0 - out));
                EXPECT_NEAR(passed, transmission * out * below, 0.02)
                    << test.name << ", factor " << transmission << ", cos " << cosine;
            }
}

// KHR_materials_transmission takes its share of the dielectric first; metals have none.
TEST(DiffuseTransmission, IsOfWhatMetalAndGlassLeave) {
    const vec3 wo = DirectionAt(0.7f, 0.3f), wi = DirectionAt(-0.4f, 2.0f);
    const vec3 alone = f(Leaf(0.3f, 0.6f, vec3(0.5f), vec3(0.2f, 0.7f, 0.4f)), wo, wi);
    ASSERT_GT(alone.y, 0.01f);
    for (const float metallic : {0.0f, 0.4f, 1.0f})
        for (const float glass : {0.0f, 0.5f, 1.0f}) {
            GltfBxDF mixed = Leaf(0.3f, 0.6f, vec3(0.5f), vec3(0.2f, 0.7f, 0.4f));
            mixed.metallic = metallic;
            mixed.transmission = glass;
            GltfBxDF without = mixed;
            without.diffuseTransmission = 0.0f;
            const vec3 diffuse = f(mixed, wo, wi) - f(without, wo, wi);
            EXPECT_LT(distance(diffuse, (1.0f - metallic) * (1.0f - glass) * alone), 1e-5f)
                << "metallic " << metallic << ", transmission " << glass;
        }
}

// Radiance is scaled by the index, and roulette is told so.
TEST(DiffuseTransmission, SamplesHaveTheEtaOfTheirMedium) {
    for (const bool isInside : {false, true}) {
        const GltfBxDF sheet = Bounding(Leaf(0.3f, 1.0f), isInside);
        uint passed = 0;
        for (int i = 0; i < 200; ++i) {
            const float uc = (float(i) + 0.5f) / 200.0f;
            const BSDFSample s = Sample_f(sheet, DirectionAt(0.6f, 0.0f), uc, vec2(0.3f, 0.4f));
            if (!(s.wi.z < 0.0f)) continue;
            ++passed;
            EXPECT_EQ(s.eta, sheet.eta);
            EXPECT_EQ(s.flags, kBxDFTransmission | kBxDFDiffuse);
        }
        EXPECT_GT(passed, 50u);
    }
}

// Glass and diffuse transmission at one boundary scale radiance alike.
TEST(DiffuseTransmission, BesideGlassIsReciprocal) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    GltfBxDF mixed = Bounding(Leaf(0.4f, 0.7f, vec3(0.8f), vec3(0.5f)), false);
    mixed.transmission = 0.5f;
    Uniform uniform(31);
    for (int i = 0; i < 200; ++i) {
        vec3 wo = uniform.Direction(), wi = uniform.Direction();
        wo.z = std::max(std::abs(wo.z), 1e-2f);
        wi.z = -std::max(std::abs(wi.z), 1e-2f);
        const float forth = f(mixed, wo, wi).x * Sqr(mixed.eta);
        const float back = f(TurnedOver(mixed), Mirrored(wi), Mirrored(wo)).x;
        EXPECT_NEAR(back, forth, 1e-3f * (1e-2f + forth)) << wo.z << ", " << wi.z;
    }
}

// The mean over the other side, for light that has been filtered, equals that of the samples.
TEST(DiffuseTransmission, MeanIsThatOfItsSamples) {
    for (const Case& test : WhiteOnes())
        for (const float cosine : {0.9f, 0.2f}) {
            const vec3 wo = DirectionAt(cosine, 0.3f);
            const GltfBSDF g = Prepare(test.sheet, wo);
            const LobeMean mean = Transmitted(g.through, g.view);
            EXPECT_TRUE(mean.isDiffuse);
            EXPECT_EQ(mean.wi, vec3(0.0f, 0.0f, -1.0f));
            EXPECT_NEAR(mean.albedo.x, MeasureAlbedo(test.sheet, wo, 1u << 14u).transmitted.x, 0.02)
                << test.name << ", cos " << cosine;
        }
}

// Walks in place of tables reflect light, and transmit the rest.
TEST(DiffuseTransmission, WalksAboveItKeepTheSum) {
    for (const MultiscatterKind kind : {MultiscatterKind::Off, MultiscatterKind::Walk}) {
        const MultiscatterScope scope(kind);
        for (const float cosine : {0.9f, 0.3f}) {
            const GltfBxDF leaf = Leaf(0.5f, 0.7f);
            const double sum = MeasureAlbedo(leaf, DirectionAt(cosine, 0.3f), 1u << 15u).Sum().x;
            EXPECT_NEAR(sum, 1.0, 0.02) << int(kind) << ", cos " << cosine;
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::diffuse_transmission_test
