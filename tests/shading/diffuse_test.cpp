// Lobes without facets: Lambert's, Lafortune's, and diffuse transmission.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/energy_bridge.h"

#include "bxdf/diffuse.glsl"
#include "bxdf/lafortune.glsl"
#include "core/rng.glsl"
#include "tests/shading/gltf_lobe.h"
#include "tests/shading/lobe_checks.h"
#include "tests/support/chi_square.h"

namespace raygraph::shading::diffuse_test {
namespace {

DiffuseBxDF Lobe(vec3 albedo) {
    DiffuseBxDF lobe;
    lobe.albedo = albedo;
    return lobe;
}

vec3 Direction(float cosTheta, float phi) {
    const float sinTheta = std::sqrt(1.0f - cosTheta * cosTheta);
    return vec3(sinTheta * std::cos(phi), sinTheta * std::sin(phi), cosTheta);
}

// Returns directions from straight above to grazing, and from below.
std::vector<vec3> Viewers() {
    return {Direction(1.0f, 0.0f), Direction(0.7f, 1.0f), Direction(0.01f, 4.0f), Direction(-0.5f, 2.0f)};
}

const vec3 kAlbedo(0.8f, 0.5f, 0.1f);

TEST(Lambert, SampledDirectionsFollowPDF) {
    const double level = test::SidakLevel(0.01, static_cast<int>(Viewers().size()));
    uint32_t seed = 100;
    for (vec3 wo : Viewers()) {
        const auto sample = [&](float uc, vec2 u) -> std::optional<vec3> {
            const BSDFSample s = Sample_f(Lobe(kAlbedo), wo, uc, u);
            if (s.pdf == 0.0f) return std::nullopt;
            return s.wi;
        };
        const auto pdf = [&](vec3 wi) { return static_cast<double>(PDF(Lobe(kAlbedo), wo, wi)); };
        EXPECT_GT(test::ChiSquareOfDirections(sample, pdf, {.seed = seed++}).pValue, level) << wo.z;
    }
}

TEST(Lambert, PDFIntegratesToOne) {
    for (vec3 wo : Viewers()) {
        const auto pdf = [&](vec3 wi) { return static_cast<double>(PDF(Lobe(kAlbedo), wo, wi)); };
        EXPECT_NEAR(test::IntegrateOverSphere(pdf, -1.0, 0.0, 0.0, 2.0 * M_PI) +
                        test::IntegrateOverSphere(pdf, 0.0, 1.0, 0.0, 2.0 * M_PI),
                    1.0, 1e-6);
    }
}

TEST(Lambert, SampleAgreesWithFAndPDF) {
    threadSamplerKind = SamplerKind::Pcg;
    for (vec3 wo : Viewers()) {
        for (uint i = 0; i < 10'000; ++i) {
            Sampler rng = StartPixelSample(uvec2(1u, 2u), i, 3u);
            const float uc = Get1D(rng);
            const BSDFSample s = Sample_f(Lobe(kAlbedo), wo, uc, Get2D(rng));
            ASSERT_GT(s.pdf, 0.0f);
            ASSERT_EQ(s.f, f(Lobe(kAlbedo), wo, s.wi));
            ASSERT_EQ(s.pdf, PDF(Lobe(kAlbedo), wo, s.wi));
            ASSERT_EQ(s.flags & ~Flags(Lobe(kAlbedo)), 0u);
            ASSERT_EQ(s.eta, 1.0f);
        }
    }
    threadSamplerKind = SamplerKind::Sobol;
}

TEST(Lambert, IsReciprocal) {
    std::mt19937 generator(5);
    const auto direction = [&] {
        return Direction(static_cast<float>(generator()) * 0x1p-31f - 1.0f,
                         static_cast<float>(generator() % 1000));
    };
    for (int i = 0; i < 10'000; ++i) {
        const vec3 a = direction();
        const vec3 b = direction();
        ASSERT_EQ(f(Lobe(kAlbedo), a, b), f(Lobe(kAlbedo), b, a));
    }
}

TEST(Lambert, FurnaceReturnsTheAlbedo) {
    for (vec3 wo : Viewers()) {
        // The albedo by quadrature of f cos over all wi ...
        for (int channel = 0; channel < 3; ++channel) {
            const auto integrand = [&](vec3 wi) {
                return static_cast<double>(f(Lobe(kAlbedo), wo, wi)[channel] * std::abs(wi.z));
            };
            EXPECT_NEAR(test::IntegrateOverSphere(integrand, -1.0, 0.0, 0.0, 2.0 * M_PI) +
                            test::IntegrateOverSphere(integrand, 0.0, 1.0, 0.0, 2.0 * M_PI),
                        static_cast<double>(kAlbedo[channel]), 1e-6);
        }
        // ... and by the estimator, which for this lobe has no variance.
        for (int i = 1; i < 64; ++i) {
            const vec2 u(static_cast<float>(i) / 64.0f, (static_cast<float>((i * 37) % 64) + 0.5f) / 64.0f);
            const BSDFSample s = Sample_f(Lobe(kAlbedo), wo, 0.5f, u);
            const vec3 weight = s.f * std::abs(s.wi.z) / s.pdf;
            EXPECT_NEAR(weight.x, kAlbedo.x, 1e-6f);
            EXPECT_NEAR(weight.y, kAlbedo.y, 1e-6f);
            EXPECT_NEAR(weight.z, kAlbedo.z, 1e-6f);
        }
    }
}

TEST(Lambert, NothingPassesThroughTheSurface) {
    const vec3 above = Direction(0.6f, 1.0f);
    const vec3 below = Direction(-0.6f, 1.0f);
    EXPECT_EQ(f(Lobe(kAlbedo), above, below), vec3(0.0f));
    EXPECT_EQ(PDF(Lobe(kAlbedo), above, below), 0.0f);
    EXPECT_LT(Sample_f(Lobe(kAlbedo), below, 0.5f, vec2(0.3f, 0.6f)).wi.z, 0.0f);
    EXPECT_TRUE(IsReflective(Flags(Lobe(kAlbedo))));
    EXPECT_TRUE(IsNonSpecular(Flags(Lobe(kAlbedo))));
    EXPECT_FALSE(IsTransmissive(Flags(Lobe(kAlbedo))));
    EXPECT_FALSE(IsSpecular(Flags(Lobe(kAlbedo))));
}

TEST(Lambert, BlackAndEdgeOnSurfacesGiveNoSample) {
    const DiffuseBxDF black = Lobe(vec3(0.0f));
    EXPECT_EQ(Flags(black), kBxDFNone);
    EXPECT_EQ(Sample_f(black, Direction(0.5f, 0.0f), 0.5f, vec2(0.3f, 0.6f)).pdf, 0.0f);
    EXPECT_EQ(PDF(black, Direction(0.5f, 0.0f), Direction(0.5f, 1.0f)), 0.0f);
    EXPECT_EQ(Sample_f(Lobe(kAlbedo), vec3(1.0f, 0.0f, 0.0f), 0.5f, vec2(0.3f, 0.6f)).pdf, 0.0f);
    // The rim of the disk has no density, and says so.
    EXPECT_EQ(Sample_f(Lobe(kAlbedo), Direction(0.5f, 0.0f), 0.5f, vec2(0.0f, 0.5f)).pdf, 0.0f);
}

}  // namespace
}  // namespace raygraph::shading::diffuse_test

namespace raygraph::shading::lafortune_test {
namespace {

LafortuneBxDF Lobe(vec3 diffuse, vec3 specular, float exponent) {
    LafortuneBxDF lobe;
    lobe.diffuse = diffuse;
    lobe.specular = specular;
    lobe.exponent = exponent;
    return lobe;
}

struct Case {
    float exponent;
    vec3 wo;
};

std::vector<Case> Cases() {
    std::vector<Case> cases;
    for (float exponent : {0.0f, 3.0f, 40.0f, 20'000.0f})
        for (float cosTheta : {1.0f, 0.5f, 0.05f, -0.7f})
            cases.push_back({exponent, DirectionAt(cosTheta, 2.0f)});
    return cases;
}

const vec3 kDiffuse(0.3f, 0.2f, 0.1f);
const vec3 kSpecular(0.4f, 0.6f, 0.5f);

PolarGrid GridOf(const Case& c) {
    if (c.exponent < 10.0f) return {};
    return PolarGrid::About(vec3(-c.wo.x, -c.wo.y, c.wo.z), c.exponent < 1000.0f ? 0.1f : 0.005f);
}

TEST(Lafortune, SampledDirectionsFollowPDF) {
    const double level = test::SidakLevel(0.01, static_cast<int>(Cases().size()));
    uint32_t seed = 6000;
    for (const Case& c : Cases()) {
        const test::ChiSquareResult result =
            ChiSquareOfLobe(Lobe(kDiffuse, kSpecular, c.exponent), c.wo, {{GridOf(c)}}, seed++);
        EXPECT_GT(result.degreesOfFreedom, 100);
        EXPECT_GT(result.pValue, level) << c.exponent << " " << c.wo.z << ", chi-squared " << result.statistic
                                        << " of " << result.degreesOfFreedom;
    }
}

// One less what is absorbed, 1 - 0.3 - 0.6, and what of the specular lobe is below the horizon: nothing of a
// narrow one, and none at all seen from above.
TEST(Lafortune, PDFIntegratesToTheChanceOfNotBeingAbsorbed) {
    for (const Case& c : Cases()) {
        const LafortuneBxDF lobe = Lobe(kDiffuse, kSpecular, c.exponent);
        const double sum =
            GridOf(c).IntegrateSum([&](vec3 wi) { return static_cast<double>(PDF(lobe, c.wo, wi)); });
        EXPECT_LT(sum, 0.901);
        if (c.wo.z == 1.0f || (c.exponent > 1000.0f && std::abs(c.wo.z) > 0.1f)) {
            EXPECT_NEAR(sum, 0.9, 1e-3) << c.exponent << " " << c.wo.z;
        } else if (c.exponent < 1000.0f && std::abs(c.wo.z) < 0.1f) {
            EXPECT_LT(sum, 0.87) << c.exponent << " " << c.wo.z;
        }
    }
}

TEST(Lafortune, SampleAgreesWithFAndPDF) {
    for (const Case& c : Cases()) ExpectSamplesAgree(Lobe(kDiffuse, kSpecular, c.exponent), c.wo, 1e-6f);
}

// Lobes are chosen with their stated probabilities: diffuse, specular, and none.
TEST(Lafortune, ChoosesAmongDiffuseSpecularAndNothing) {
    const LafortuneBxDF lobe = Lobe(kDiffuse, kSpecular, 20.0f);
    const vec3 wo(0.0f, 0.0f, 1.0f);
    EXPECT_EQ(Sample_f(lobe, wo, 0.299f, vec2(0.3f, 0.6f)).flags, kBxDFReflection | kBxDFDiffuse);
    EXPECT_EQ(Sample_f(lobe, wo, 0.301f, vec2(0.3f, 0.6f)).flags, kBxDFReflection | kBxDFGlossy);
    EXPECT_EQ(Sample_f(lobe, wo, 0.899f, vec2(0.3f, 0.6f)).flags, kBxDFReflection | kBxDFGlossy);
    EXPECT_EQ(Sample_f(lobe, wo, 0.901f, vec2(0.3f, 0.6f)).pdf, 0.0f);
    EXPECT_EQ(Flags(Lobe(kDiffuse, vec3(0.0f), 1.0f)), kBxDFReflection | kBxDFDiffuse);
    EXPECT_EQ(Flags(Lobe(vec3(0.0f), kSpecular, 1.0f)), kBxDFReflection | kBxDFGlossy);
    EXPECT_EQ(Flags(Lobe(vec3(0.0f), vec3(0.0f), 1.0f)), kBxDFNone);
    // Shares that lie in different channels leave nothing to absorb.
    const vec2 chances = LobeProbabilities(Lobe(vec3(0.9f, 0.0f, 0.0f), vec3(0.0f, 0.9f, 0.0f), 1.0f));
    EXPECT_NEAR(chances.x, 0.5f, 1e-6f);
    EXPECT_NEAR(chances.y, 0.5f, 1e-6f);
}

TEST(Lafortune, IsReciprocal) {
    Uniform uniform(19);
    for (const Case& c : Cases()) {
        const LafortuneBxDF lobe = Lobe(kDiffuse, kSpecular, c.exponent);
        for (int i = 0; i < 500; ++i) {
            const vec3 wi = i % 2 == 0 ? uniform.Direction() : Sample_f(lobe, c.wo, 0.5f, uniform.Pair()).wi;
            const vec3 forth = f(lobe, c.wo, wi);
            const float tolerance = 1e-5f + 1e-8f * c.exponent;
            ASSERT_NEAR(f(lobe, wi, c.wo).y, forth.y, tolerance * (1e-3f + forth.y)) << c.exponent;
        }
    }
}

// (n + 2) / (2 pi) makes the specular share the albedo at normal incidence; elsewhere it is less.
TEST(Lafortune, FurnaceReturnsTheSharesAtNormalIncidenceAndNeverMore) {
    uint32_t seed = 7000;
    for (const Case& c : Cases()) {
        const LafortuneBxDF lobe = Lobe(kDiffuse, kSpecular, c.exponent);
        const double albedo = GridOf(c).IntegrateSum(
            [&](vec3 wi) { return static_cast<double>(f(lobe, c.wo, wi).x * std::abs(wi.z)); });
        EXPECT_LT(albedo, 0.7005) << c.exponent;
        EXPECT_TRUE(c.wo.z != 1.0f || std::abs(albedo - 0.7) < 5e-4) << c.exponent << " " << albedo;
        const Estimate estimate = EstimateAlbedo(lobe, c.wo, seed++);
        EXPECT_NEAR(estimate.mean, albedo, 5.0 * estimate.error + 5e-4) << c.exponent << " " << c.wo.z;
    }
}

TEST(Lafortune, ExponentsOfAlphaGiveFiniteLobes) {
    EXPECT_EQ(LafortuneExponent(1.0f), 0.0f);
    EXPECT_NEAR(LafortuneExponent(0.1f), 49.5f, 1e-3f);
    for (float alpha : {0.0f, 1e-3f, 0.5f, 2.0f}) {
        const LafortuneBxDF lobe = Lobe(kDiffuse, kSpecular, LafortuneExponent(alpha));
        for (vec2 u : {vec2(0.0f, 0.0f), vec2(1.0f - 0x1p-24f, 0.5f)}) {
            const BSDFSample s = Sample_f(lobe, DirectionAt(0.7f, 0.0f), 0.5f, u);
            EXPECT_TRUE(std::isfinite(s.pdf) && std::isfinite(s.f.x));
        }
    }
    EXPECT_EQ(f(Lobe(kDiffuse, kSpecular, 1.0f), DirectionAt(0.5f, 0.0f), DirectionAt(-0.5f, 0.0f)),
              vec3(0.0f));
    EXPECT_EQ(Sample_f(Lobe(kDiffuse, kSpecular, 1.0f), vec3(1.0f, 0.0f, 0.0f), 0.5f, vec2(0.3f, 0.6f)).pdf,
              0.0f);
}

}  // namespace
}  // namespace raygraph::shading::lafortune_test

// Diffuse transmission: what passes to the other side of a surface, under the layers that are on both sides.
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
