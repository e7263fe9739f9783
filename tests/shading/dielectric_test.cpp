#include "bxdf/dielectric.glsl"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bxdf/conductor.glsl"
#include "tests/shading/lobe_checks.h"
#include "tests/shading/microfacet_cases.h"

namespace raygraph::shading {
namespace {

DielectricBxDF Glass(vec2 alpha, float eta, bool isThin = false) {
    DielectricBxDF lobe;
    lobe.distribution = MakeMicrofacetDistribution(alpha);
    lobe.eta = eta;
    lobe.isThin = isThin;
    return lobe;
}

struct GlassCase {
    MicrofacetCase surface;
    float eta;
    bool isThin;
    [[nodiscard]] DielectricBxDF Lobe() const { return Glass(surface.alpha, eta, isThin); }
};

std::ostream& operator<<(std::ostream& out, const GlassCase& c) {
    return out << c.surface << ", eta " << c.eta << (c.isThin ? ", thin" : "");
}

std::vector<GlassCase> GlassCases(bool isLong) {
    std::vector<GlassCase> cases;
    const auto add = [&](MicrofacetModel distribution, float x, float y, float cosTheta, float eta,
                         bool isThin) {
        cases.push_back({{distribution, vec2(x, y), DirectionAt(cosTheta, 0.6f)}, eta, isThin});
    };
    const std::vector<float> roughnesses =
        isLong ? std::vector{0.05f, 0.1f, 0.3f, 0.6f, 1.0f} : std::vector{0.05f, 0.6f, 1.0f};
    const std::vector<float> cosines =
        isLong ? std::vector{1.0f, 0.5f, 0.05f, -0.9f, -0.3f} : std::vector{0.6f, -0.6f};
    for (float eta : {1.1f, 1.5f, 2.4f, 1.0f / 1.5f}) {
        for (float roughness : roughnesses)
            for (float cosTheta : cosines)
                add(MicrofacetModel::Ggx, roughness * roughness, roughness * roughness, cosTheta, eta, false);
    }
    add(MicrofacetModel::Ggx, 0.36f, 0.36f, 0.05f, 1.5f, false);
    add(MicrofacetModel::Ggx, 0.15f, 0.6f, 0.7f, 1.5f, false);
    add(MicrofacetModel::Ggx, 0.36f, 0.36f, 0.7f, 1.5f, true);
    add(MicrofacetModel::Ggx, 0.0025f, 0.0025f, -0.4f, 1.5f, true);
    for (MicrofacetModel distribution : {MicrofacetModel::Beckmann, MicrofacetModel::Phong}) {
        add(distribution, 0.36f, 0.36f, 0.4f, 1.5f, false);
        add(distribution, 0.36f, 0.36f, -0.6f, 1.5f, false);
        add(distribution, 0.5f, 0.25f, 0.6f, 1.5f, true);
    }
    return cases;
}

constexpr std::array kCurves = {FresnelModel::Schlick, FresnelModel::Dielectric};

// A grid on which one side of the lobe is smooth: light reflected, or light that passes.
PolarGrid GridOf(const GlassCase& c, bool isReflection) {
    float least = std::min(c.surface.alpha.x, c.surface.alpha.y);
    // Facets turn light that passes by the less, the closer the indices.
    if (!isReflection && !c.isThin) least *= std::min(std::abs(c.eta - 1.0f), 1.0f);
    if (least >= 0.15f) return {};
    const vec3 wo = c.surface.wo;
    const vec3 up(0.0f, 0.0f, wo.z < 0.0f ? -1.0f : 1.0f);
    vec3 axis = isReflection ? Reflect(wo, up) : -wo;
    if (!isReflection && !c.isThin && !Refract(wo, up, wo.z < 0.0f ? 1.0f / c.eta : c.eta, axis)) axis = -up;
    return PolarGrid::About(axis, least);
}

std::function<bool(vec3)> IsOnSide(vec3 wo, bool isReflection) {
    return [wo, isReflection](vec3 wi) { return SameHemisphere(wo, wi) == isReflection; };
}

TEST(Dielectric, SampledDirectionsFollowPDF) {
    const std::vector<GlassCase> cases = GlassCases(AreTestsLong());
    const double level = test::SidakLevel(0.01, static_cast<int>(cases.size()));
    uint32_t seed = 4000;
    for (const GlassCase& c : cases) {
        const ScopedModels models(c.surface.distribution, MaskingModel::Correlated, kCurves[seed % 2]);
        const vec3 wo = c.surface.wo;
        const std::vector<LobePart> parts = {{GridOf(c, true), IsOnSide(wo, true)},
                                             {GridOf(c, false), IsOnSide(wo, false)}};
        const test::ChiSquareResult result = ChiSquareOfLobe(c.Lobe(), wo, parts, seed++);
        EXPECT_GT(result.degreesOfFreedom, 50) << c;
        EXPECT_GT(result.pValue, level)
            << c << ", chi-squared " << result.statistic << " of " << result.degreesOfFreedom;
    }
}

// With visible normals nothing is lost but what facets send to other facets: next to nothing when nearly
// smooth.
TEST(Dielectric, PDFIntegratesToOneWhereNoLightMeetsASecondFacet) {
    for (FresnelModel curve : kCurves) {
        const ScopedModels models(MicrofacetModel::Ggx, MaskingModel::Correlated, curve);
        for (float eta : {1.1f, 1.5f, 2.4f, 1.0f / 1.5f}) {
            for (float cosTheta : {0.9f, 0.5f, -0.9f, -0.5f}) {
                for (bool isThin : {false, true}) {
                    const GlassCase c{
                        {MicrofacetModel::Ggx, vec2(0.0025f, 0.0025f), DirectionAt(cosTheta, 0.6f)},
                        eta,
                        isThin};
                    double sum = 0.0;
                    for (bool isReflection : {true, false}) {
                        const auto counts = IsOnSide(c.surface.wo, isReflection);
                        sum += GridOf(c, isReflection).IntegrateSum([&](vec3 wi) {
                            return counts(wi) ? static_cast<double>(PDF(c.Lobe(), c.surface.wo, wi)) : 0.0;
                        });
                    }
                    EXPECT_NEAR(sum, 1.0, 2e-3) << c;
                }
            }
        }
    }
}

TEST(Dielectric, SampleAgreesWithFAndPDF) {
    for (const GlassCase& c : GlassCases(true)) {
        for (MaskingModel masking : kMaskingModels) {
            SCOPED_TRACE(testing::Message() << c << ", masking " << static_cast<int>(masking));
            const ScopedModels models(c.surface.distribution, masking, FresnelModel::Dielectric);
            // The normal found again from wi is off by rounding, more so where wo and wi nearly cancel.
            const float contrast = c.isThin ? 1.0f : std::abs(c.eta - 1.0f);
            const float least = std::min(c.surface.alpha.x, c.surface.alpha.y);
            ExpectSamplesAgree(c.Lobe(), c.surface.wo, (1e-4f + 4e-6f / least) / std::min(contrast, 1.0f),
                               500);
        }
    }
}

TEST(Dielectric, IsReciprocalButForTheSquareOfTheIndex) {
    Uniform uniform(13);
    int transmittedCount = 0;
    for (const GlassCase& c : GlassCases(true)) {
        for (MaskingModel masking : kMaskingModels) {
            const ScopedModels models(c.surface.distribution, masking, kCurves[uniform() < 0.5f ? 0 : 1]);
            const DielectricBxDF lobe = c.Lobe();
            const float contrast = c.isThin ? 1.0f : std::abs(c.eta - 1.0f);
            const float tolerance =
                (1e-4f + 4e-6f / std::min(c.surface.alpha.x, c.surface.alpha.y)) / std::min(contrast, 1.0f);
            const auto index2 = [&](vec3 w) { return w.z < 0.0f && !c.isThin ? c.eta * c.eta : 1.0f; };
            for (int i = 0; i < 60; ++i) {
                const vec3 wo = c.surface.wo;
                const float uc = uniform();
                const vec3 wi = i % 3 == 0 ? uniform.Direction() : Sample_f(lobe, wo, uc, uniform.Pair()).wi;
                const float forth = f(lobe, wo, wi).x * index2(wi);
                const float back = f(lobe, wi, wo).x * index2(wo);
                // Near the critical angle the cosine on the far side is a root of next to nothing.
                const vec3 wm = RefractionNormal(wo, wi, EtaAhead(lobe, wo));
                const float graze = std::min(std::abs(dot(wo, wm)), std::abs(dot(wi, wm)));
                const float rounding = tolerance + 5e-7f / std::max(graze * graze, 1e-6f);
                ASSERT_NEAR(forth, back, rounding * (1e-3f + forth)) << c << " to cos " << wi.z;
                if (forth > 0.0f && !SameHemisphere(wo, wi)) ++transmittedCount;
            }
        }
    }
    EXPECT_GT(transmittedCount, 1000);
}

TEST(Dielectric, WhiteFurnaceNeverGainsEnergy) {
    uint32_t seed = 5000;
    for (const GlassCase& c : GlassCases(AreTestsLong())) {
        for (MaskingModel masking : kMaskingModels) {
            const ScopedModels models(c.surface.distribution, masking, kCurves[seed % 2]);
            const vec3 wo = c.surface.wo;
            const float eta = c.isThin ? 1.0f : wo.z < 0.0f ? 1.0f / c.eta : c.eta;
            double albedo = 0.0;
            for (bool isReflection : {true, false}) {
                const auto counts = IsOnSide(wo, isReflection);
                const float scale = isReflection ? 1.0f : eta * eta;
                albedo += GridOf(c, isReflection).IntegrateSum([&](vec3 wi) {
                    return counts(wi) ? static_cast<double>(scale * f(c.Lobe(), wo, wi).x * std::abs(wi.z))
                                      : 0.0;
                });
            }
            EXPECT_LT(albedo, c.surface.distribution == MicrofacetModel::Ggx ? 1.001 : 1.006) << c;
            const Estimate estimate = EstimateAlbedo(c.Lobe(), wo, seed++, 50'000);
            EXPECT_NEAR(estimate.mean, albedo, 5.0 * estimate.error + 2e-3)
                << c << ", masking " << static_cast<int>(masking);
        }
    }
}

TEST(Dielectric, SmoothGlassReflectsAndRefractsAllOfTheLight) {
    for (float eta : {1.1f, 1.5f, 2.4f, 1.0f / 1.5f}) {
        const DielectricBxDF lobe = Glass(vec2(0.0f, 0.0f), eta);
        EXPECT_EQ(Flags(lobe), kBxDFReflection | kBxDFTransmission | kBxDFSpecular);
        for (float cosTheta : {1.0f, 0.6f, 0.01f, -0.05f, -0.9f}) {
            const ScopedModels models(MicrofacetModel::Ggx, MaskingModel::Correlated,
                                      FresnelModel::Dielectric);
            const vec3 wo = DirectionAt(cosTheta, 0.6f);
            const float ahead = wo.z < 0.0f ? 1.0f / eta : eta;
            const float reflected = FresnelDielectric(cosTheta, eta);
            const BSDFSample r = Sample_f(lobe, wo, 0.0f, vec2(0.3f, 0.6f));
            EXPECT_EQ(r.wi, vec3(-wo.x, -wo.y, wo.z));
            EXPECT_NEAR(r.pdf, reflected, 1e-6f);
            EXPECT_NEAR(r.f.x * std::abs(r.wi.z) / r.pdf, 1.0f, 1e-5f);
            EXPECT_EQ(r.eta, 1.0f);
            EXPECT_EQ(f(lobe, wo, r.wi), vec3(0.0f));
            EXPECT_EQ(PDF(lobe, wo, r.wi), 0.0f);
            const BSDFSample t = Sample_f(lobe, wo, 0.9999999f, vec2(0.3f, 0.6f));
            if (reflected == 1.0f) {
                EXPECT_TRUE(IsReflective(t.flags));
                continue;
            }
            EXPECT_TRUE(IsTransmissive(t.flags) && IsSpecular(t.flags));
            EXPECT_FALSE(SameHemisphere(wo, t.wi));
            EXPECT_EQ(t.eta, ahead);
            EXPECT_NEAR(std::hypot(t.wi.x, t.wi.y) * ahead, std::hypot(wo.x, wo.y), 2e-6f);
            EXPECT_NEAR(t.pdf, 1.0f - reflected, 1e-6f);
            EXPECT_NEAR(t.f.x * std::abs(t.wi.z) / t.pdf * ahead * ahead, 1.0f, 1e-5f);
        }
    }
}

TEST(Dielectric, ThinSheetLetsLightStraightThrough) {
    const DielectricBxDF smooth = Glass(vec2(0.0f, 0.0f), 1.5f, true);
    for (float cosTheta : {0.7f, -0.2f}) {
        const vec3 wo = DirectionAt(cosTheta, 0.6f);
        const BSDFSample t = Sample_f(smooth, wo, 0.999f, vec2(0.3f, 0.6f));
        EXPECT_EQ(t.wi, -wo);
        EXPECT_EQ(t.eta, 1.0f);
        EXPECT_TRUE(IsTransmissive(t.flags));
        // Either face reflects as the outside of the glass does: there is no total reflection.
        EXPECT_NEAR(t.pdf, 1.0f - FresnelSchlickDielectric(std::abs(cosTheta), 1.5f), 1e-6f);
    }
    // What a rough sheet reflects and lets through is what white facets reflect.
    const DielectricBxDF rough = Glass(vec2(0.3f, 0.5f), 1.5f, true);
    ConductorBxDF white;
    white.distribution = rough.distribution;
    white.fresnel = ConductorFromColor(vec3(1.0f), vec3(1.0f));
    Uniform uniform(17);
    for (int i = 0; i < 1000; ++i) {
        const vec3 wo = uniform.Direction();
        const vec3 wi = uniform.Direction();
        const float sum = f(rough, wo, wi).x + f(rough, wo, vec3(wi.x, wi.y, -wi.z)).x;
        const float all = std::max(f(white, wo, wi).x, f(white, wo, vec3(wi.x, wi.y, -wi.z)).x);
        ASSERT_NEAR(sum, all, 1e-5f * (1.0f + all));
    }
}

TEST(Dielectric, EqualIndicesLetEverythingThrough) {
    const DielectricBxDF lobe = Glass(vec2(0.5f, 0.5f), 1.0f);
    EXPECT_EQ(Flags(lobe), kBxDFTransmission | kBxDFSpecular);
    const vec3 wo = DirectionAt(0.3f, 1.0f);
    for (float uc : {0.0f, 0.5f}) {
        const BSDFSample s = Sample_f(lobe, wo, uc, vec2(0.3f, 0.6f));
        EXPECT_LT(length(s.wi + wo), 1e-6f);
        EXPECT_NEAR(s.f.x * std::abs(s.wi.z) / s.pdf, 1.0f, 1e-5f);
    }
    EXPECT_EQ(f(lobe, wo, -wo), vec3(0.0f));
    EXPECT_EQ(Sample_f(lobe, vec3(1.0f, 0.0f, 0.0f), 0.5f, vec2(0.3f, 0.6f)).pdf, 0.0f);
}

}  // namespace
}  // namespace raygraph::shading
