#include "tests/shading/lone_lobe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/shading/lobe_checks.h"
#include "tests/shading/microfacet_cases.h"

namespace raygraph::shading::conductor_test {
namespace {

LoneLobe<ConductorBxDF> White(vec2 alpha) {
    LoneLobe<ConductorBxDF> white{};
    white.lobe.fresnel = ConductorFromColor(vec3(1.0f), vec3(1.0f));
    white.lobe.scale = vec3(1.0f);
    white.setting.alpha = alpha;
    return white;
}

LoneLobe<ConductorBxDF> Gold(vec2 alpha) {
    LoneLobe<ConductorBxDF> gold = White(alpha);
    gold.lobe.fresnel = ConductorFromIndices(vec3(0.143f, 0.375f, 1.442f), vec3(3.983f, 2.386f, 1.603f));
    return gold;
}

// A grid on which the lobe of wo is smooth.
PolarGrid GridOf(vec2 alpha, vec3 wo) {
    const float least = std::min(alpha.x, alpha.y);
    return least >= 0.2f ? PolarGrid{} : PolarGrid::About(vec3(-wo.x, -wo.y, wo.z), least);
}

TEST(Conductor, SampledDirectionsFollowPDF) {
    const std::vector<MicrofacetCase> cases = MicrofacetCases(AreTestsLong());
    const double level = test::SidakLevel(0.01, static_cast<int>(cases.size()));
    uint32_t seed = 1000;
    for (const MicrofacetCase& c : cases) {
        const ScopedModels models(c.distribution);
        const LoneLobe<ConductorBxDF> lobe = White(c.alpha);
        const test::ChiSquareResult result = ChiSquareOfLobe(lobe, c.wo, {{GridOf(c.alpha, c.wo)}}, seed++);
        EXPECT_GT(result.degreesOfFreedom, 20) << c;
        EXPECT_GT(result.pValue, level)
            << c << ", chi-squared " << result.statistic << " of " << result.degreesOfFreedom;
    }
}

// Sampled normals that reflect wo below the horizon give no sample; PDF lacks exactly these.
TEST(Conductor, PDFIntegratesToTheShareOfNormalsThatReflectAboveTheHorizon) {
    for (const MicrofacetCase& c : MicrofacetCases(AreTestsLong())) {
        if (c.wo.z < 0.0f) continue;
        const ScopedModels models(c.distribution);
        const LoneLobe<ConductorBxDF> lobe = White(c.alpha);
        const PolarGrid normals = std::max(c.alpha.x, c.alpha.y) < 0.1f
                                      ? PolarGrid::About(vec3(0.0f, 0.0f, 1.0f), c.alpha.x)
                                      : PolarGrid{};
        const double above = normals.IntegrateSum([&](vec3 wm) {
            if (wm.z <= 0.0f || dot(c.wo, wm) <= 0.0f || Reflect(c.wo, wm).z <= 0.0f) return 0.0;
            return static_cast<double>(PDF(MakeMicrofacetDistribution(c.alpha), c.wo, wm));
        });
        const double pdf = GridOf(c.alpha, c.wo).IntegrateSum([&](vec3 wi) {
            return static_cast<double>(PDF(lobe, c.wo, wi));
        });
        EXPECT_NEAR(pdf, above, 2e-3) << c;
        EXPECT_LT(pdf, 1.001) << c;
    }
}

TEST(Conductor, SampleAgreesWithFAndPDF) {
    for (const MicrofacetCase& c : MicrofacetCases(true)) {
        SCOPED_TRACE(::testing::Message() << c);
        for (MaskingModel masking : kMaskingModels) {
            const ScopedModels models(c.distribution, masking);
            // The normal found again from wi is off by rounding, which a narrow lobe magnifies.
            ExpectSamplesAgree(Gold(c.alpha), c.wo, 1e-4f + 2e-6f / std::min(c.alpha.x, c.alpha.y), 500);
        }
    }
}

TEST(Conductor, IsReciprocal) {
    Uniform uniform(11);
    for (const MicrofacetCase& c : MicrofacetCases(true)) {
        for (MaskingModel masking : kMaskingModels) {
            const ScopedModels models(c.distribution, masking);
            const LoneLobe<ConductorBxDF> lobe = Gold(c.alpha);
            const float tolerance = 2e-5f + 1e-6f / std::min(c.alpha.x, c.alpha.y);
            for (int i = 0; i < 100; ++i) {
                // Half of the pairs are within the lobe.
                const vec3 wi =
                    i % 2 == 0 ? uniform.Direction() : Sample_f(lobe, c.wo, 0.5f, uniform.Pair()).wi;
                const vec3 forth = f(lobe, c.wo, wi);
                ASSERT_NEAR(f(lobe, wi, c.wo).x, forth.x, tolerance * (1e-3f + forth.x)) << c;
            }
        }
    }
}

// White microfacets reflect at most what comes in; sampling finds what quadrature does.
TEST(Conductor, WhiteFurnaceNeverGainsEnergy) {
    uint32_t seed = 2000;
    for (const MicrofacetCase& c : MicrofacetCases(AreTestsLong())) {
        for (MaskingModel masking : kMaskingModels) {
            const ScopedModels models(c.distribution, masking);
            const LoneLobe<ConductorBxDF> lobe = White(c.alpha);
            const double albedo = GridOf(c.alpha, c.wo).IntegrateSum([&](vec3 wi) {
                return static_cast<double>(f(lobe, c.wo, wi).x * std::abs(wi.z));
            });
            // Beckmann's masking is a fit, and Phong's rests on it.
            EXPECT_LT(albedo, c.distribution == MicrofacetModel::Ggx ? 1.0005 : 1.006)
                << c << " masking " << static_cast<int>(masking);
            const Estimate estimate = EstimateAlbedo(lobe, c.wo, seed++, 50'000);
            EXPECT_NEAR(estimate.mean, albedo, 5.0 * estimate.error + 2e-3)
                << c << " masking " << static_cast<int>(masking);
        }
    }
}

TEST(Conductor, SmoothSurfaceIsAMirror) {
    const LoneLobe<ConductorBxDF> lobe = Gold(vec2(9e-4f, 5e-4f));
    EXPECT_EQ(Flags(lobe), kBxDFReflection | kBxDFSpecular);
    for (float cosTheta : {1.0f, 0.5f, 1e-3f, -0.7f}) {
        const vec3 wo = DirectionAt(cosTheta, 0.4f);
        const BSDFSample s = Sample_f(lobe, wo, 0.5f, vec2(0.3f, 0.6f));
        EXPECT_EQ(s.wi, vec3(-wo.x, -wo.y, wo.z));
        EXPECT_TRUE(IsSpecular(s.flags));
        const vec3 reflected = s.f * std::abs(s.wi.z) / s.pdf;
        EXPECT_NEAR(reflected.x, ConductorReflectance(lobe.lobe.fresnel, std::abs(cosTheta)).x, 1e-6f);
        EXPECT_EQ(f(lobe, wo, s.wi), vec3(0.0f));
        EXPECT_EQ(PDF(lobe, wo, s.wi), 0.0f);
    }
}

TEST(Conductor, NothingPassesThrough) {
    const LoneLobe<ConductorBxDF> lobe = White(vec2(0.3f, 0.3f));
    EXPECT_EQ(Flags(lobe), kBxDFReflection | kBxDFGlossy);
    EXPECT_EQ(f(lobe, DirectionAt(0.5f, 0.0f), DirectionAt(-0.5f, 3.0f)), vec3(0.0f));
    EXPECT_EQ(PDF(lobe, DirectionAt(0.5f, 0.0f), DirectionAt(-0.5f, 3.0f)), 0.0f);
    EXPECT_LT(Sample_f(lobe, DirectionAt(-0.5f, 0.0f), 0.5f, vec2(0.3f, 0.6f)).wi.z, 0.0f);
    EXPECT_EQ(Transmitted(lobe.lobe, FacetsOf(lobe.setting, DirectionAt(0.5f, 0.0f))).albedo, vec3(0.0f));
}

// With and without multiple scattering, a metal's stated albedo is that of its samples, and its weight is
// that of gray.
TEST(Conductor, StatedAlbedoIsReflected) {
    for (const MultiscatterKind kind : {MultiscatterKind::Off, MultiscatterKind::Lut}) {
        const MultiscatterScope scope(kind);
        for (const float alpha : {0.05f, 0.3f, 0.8f}) {
            for (const float cosine : {0.9f, 0.3f}) {
                const vec3 wo = DirectionAt(cosine, 0.7f);
                GltfBxDF gray = Metal(alpha, vec3(0.6f));
                gray.metallic = 0.7f;
                const LoneLobe<ConductorBxDF> lone{PlacedLobe<ConductorBxDF>(gray, wo), gray};
                const FacetView view = ViewOf(gray, wo);
                const LobeMean mean = Reflected(lone.lobe, view);
                const Estimate sampled = EstimateAlbedo(lone, wo, 31);
                EXPECT_NEAR(mean.albedo.x, sampled.mean, 5.0 * sampled.error + 2e-3)
                    << "kind " << static_cast<int>(kind) << " alpha " << alpha << " cos " << cosine;
                EXPECT_FLOAT_EQ(Weight(lone.lobe, view), mean.albedo.x);
                EXPECT_GT(mean.albedo.x, 0.1f);
            }
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::conductor_test
