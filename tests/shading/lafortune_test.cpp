#include "bxdf/lafortune.glsl"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/shading/lobe_checks.h"

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
