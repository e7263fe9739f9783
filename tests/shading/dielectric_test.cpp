// Glass, and the layer of a dielectric over an opaque base.
#include "tests/shading/lone_lobe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/shading/lobe_checks.h"
#include "tests/shading/microfacet_cases.h"

namespace raygraph::shading::dielectric_test {
namespace {

LoneLobe<GlassBxDF> LoneGlass(vec2 alpha, float eta, bool isThin = false) {
    SurfaceSetting setting{};
    setting.eta = eta;
    setting.isThin = isThin;
    setting.alpha = alpha;
    return {GlassOf(Glass(0.0f, eta), eta, isThin, 1.0f), setting};
}

struct GlassCase {
    MicrofacetCase surface;
    float eta;
    bool isThin;
    [[nodiscard]] LoneLobe<GlassBxDF> Lobe() const { return LoneGlass(surface.alpha, eta, isThin); }
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

TEST(Glass, SampledDirectionsFollowPDF) {
    const MultiscatterScope single(MultiscatterKind::Off);
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

// With visible normals, only light that meets a second facet is lost: next to nothing when nearly smooth.
TEST(Glass, PDFIntegratesToOneWhereNoLightMeetsASecondFacet) {
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

TEST(Glass, SampleAgreesWithFAndPDF) {
    const MultiscatterScope single(MultiscatterKind::Off);
    for (const GlassCase& c : GlassCases(true)) {
        for (MaskingModel masking : kMaskingModels) {
            SCOPED_TRACE(::testing::Message() << c << ", masking " << static_cast<int>(masking));
            const ScopedModels models(c.surface.distribution, masking, FresnelModel::Dielectric);
            // The normal found again from wi is off by rounding, more so where wo and wi nearly cancel.
            const float contrast = c.isThin ? 1.0f : std::abs(c.eta - 1.0f);
            const float least = std::min(c.surface.alpha.x, c.surface.alpha.y);
            ExpectSamplesAgree(c.Lobe(), c.surface.wo, (1e-4f + 4e-6f / least) / std::min(contrast, 1.0f),
                               500);
        }
    }
}

TEST(Glass, IsReciprocalButForTheSquareOfTheIndex) {
    const MultiscatterScope single(MultiscatterKind::Off);
    Uniform uniform(13);
    int transmittedCount = 0;
    for (const GlassCase& c : GlassCases(true)) {
        for (MaskingModel masking : kMaskingModels) {
            const ScopedModels models(c.surface.distribution, masking, kCurves[uniform() < 0.5f ? 0 : 1]);
            const LoneLobe<GlassBxDF> lobe = c.Lobe();
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
                const vec3 wm = RefractionNormal(wo, wi, wo.z < 0.0f ? 1.0f / c.eta : c.eta);
                const float graze = std::min(std::abs(dot(wo, wm)), std::abs(dot(wi, wm)));
                const float rounding = tolerance + 5e-7f / std::max(graze * graze, 1e-6f);
                ASSERT_NEAR(forth, back, rounding * (1e-3f + forth)) << c << " to cos " << wi.z;
                if (forth > 0.0f && !SameHemisphere(wo, wi)) ++transmittedCount;
            }
        }
    }
    EXPECT_GT(transmittedCount, 1000);
}

TEST(Glass, WhiteFurnaceNeverGainsEnergy) {
    const MultiscatterScope single(MultiscatterKind::Off);
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

TEST(Glass, SmoothGlassReflectsAndRefractsAllOfTheLight) {
    for (float eta : {1.1f, 1.5f, 2.4f, 1.0f / 1.5f}) {
        const LoneLobe<GlassBxDF> lobe = LoneGlass(vec2(0.0f, 0.0f), eta);
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

TEST(Glass, ThinSheetLetsLightStraightThrough) {
    const LoneLobe<GlassBxDF> smooth = LoneGlass(vec2(0.0f, 0.0f), 1.5f, true);
    for (float cosTheta : {0.7f, -0.2f}) {
        const vec3 wo = DirectionAt(cosTheta, 0.6f);
        const BSDFSample t = Sample_f(smooth, wo, 0.999f, vec2(0.3f, 0.6f));
        EXPECT_EQ(t.wi, -wo);
        EXPECT_EQ(t.eta, 1.0f);
        EXPECT_TRUE(IsTransmissive(t.flags));
        // Either face reflects as the outside of the glass does: there is no total reflection.
        EXPECT_NEAR(t.pdf, 1.0f - FresnelSchlick(std::abs(cosTheta), 0.04f, 1.0f), 1e-6f);
    }
    // A rough sheet reflects and transmits as much as white facets reflect.
    const LoneLobe<GlassBxDF> rough = LoneGlass(vec2(0.3f, 0.5f), 1.5f, true);
    LoneLobe<ConductorBxDF> white{{}, rough.setting};
    white.lobe.fresnel = ConductorFromColor(vec3(1.0f), vec3(1.0f));
    white.lobe.scale = vec3(1.0f);
    Uniform uniform(17);
    for (int i = 0; i < 1000; ++i) {
        const vec3 wo = uniform.Direction();
        const vec3 wi = uniform.Direction();
        const float sum = f(rough, wo, wi).x + f(rough, wo, vec3(wi.x, wi.y, -wi.z)).x;
        const float all = std::max(f(white, wo, wi).x, f(white, wo, vec3(wi.x, wi.y, -wi.z)).x);
        ASSERT_NEAR(sum, all, 1e-5f * (1.0f + all));
    }
}

// Nothing is reflected or refracted, whatever the roughness. Facets that transmit light once mask each other:
// the fraction G2 / G1 of them is seen from both sides, Euler's beta function of 1 + Lambda above and below
// (Heitz et al. 2016). With multiple scattering nothing is lost.
TEST(Glass, EqualIndicesLetEverythingThrough) {
    const vec3 wo = DirectionAt(0.3f, 1.0f);
    for (const float alpha : {0.0f, 0.5f}) {
        const GltfBxDF material = Glass(alpha, 1.0f);
        const double slope2 = Sqr(alpha) * (1.0 / 0.09 - 1.0);
        const double lambda = 0.5 * (std::sqrt(1.0 + slope2) - 1.0);
        const double seen = std::beta(1.0 + lambda, 1.0 + lambda) * (1.0 + lambda);
        {
            const MultiscatterScope single(MultiscatterKind::Off);
            const LoneLobe<GlassBxDF> lone{PlacedLobe<GlassBxDF>(material, wo), material};
            Uniform uniform(23);
            for (int i = 0; i < 100; ++i) {
                const float uc = uniform();
                const BSDFSample s = Sample_f(lone, wo, uc, uniform.Pair());
                ASSERT_TRUE(IsTransmissive(s.flags)) << alpha;
                ASSERT_EQ(s.eta, 1.0f);
                ASSERT_LT(length(s.wi + wo), alpha == 0.0f ? 1e-6f : 0.03f);
            }
            EXPECT_NEAR(EstimateAlbedo(lone, wo, 24).mean, seen, alpha == 0.0f ? 1e-5 : 4e-3);
        }
        const MultiscatterScope all(MultiscatterKind::Lut);
        const LoneLobe<GlassBxDF> lone{PlacedLobe<GlassBxDF>(material, wo), material};
        EXPECT_NEAR(EstimateAlbedo(lone, wo, 24).mean, 1.0, alpha == 0.0f ? 1e-5 : 7e-3);
    }
}

// The albedos of reflection and of transmission are separate, and a viewer finds both.
TEST(Glass, StatedAlbedoIsReflectedAndTransmitted) {
    for (const MultiscatterKind kind : {MultiscatterKind::Off, MultiscatterKind::Lut}) {
        const MultiscatterScope scope(kind);
        for (const bool isThin : {false, true}) {
            for (const float cosine : {0.9f, 0.4f}) {
                const vec3 wo = DirectionAt(cosine, 0.7f);
                GltfBxDF pane = Glass(0.1f, 1.5f);
                pane.isThin = isThin;
                pane.metallic = 0.2f;
                pane.baseColor = vec3(0.5f);
                const FacetView view = ViewOf(pane, wo);
                const GlassBxDF lobe = PlacedLobe<GlassBxDF>(pane, wo);
                double reflected = 0.0;
                double transmitted = 0.0;
                constexpr int kCount = 40'000;
                Uniform uniform(29);
                for (int i = 0; i < kCount; ++i) {
                    const float uc = uniform();
                    const BSDFSample s = Sample_f(lobe, view, uc, uniform.Pair());
                    if (s.pdf == 0.0f) continue;
                    const double weight =
                        static_cast<double>(s.f.x * std::abs(s.wi.z) / s.pdf * s.eta * s.eta) / kCount;
                    (s.wi.z > 0.0f ? reflected : transmitted) += weight;
                }
                EXPECT_NEAR(Reflected(lobe, view).albedo.x, reflected, 0.012) << isThin << " " << cosine;
                EXPECT_NEAR(Transmitted(lobe, view).albedo.x, transmitted, 0.02) << isThin << " " << cosine;
                EXPECT_GT(transmitted, 0.3);
                const vec3 ahead = Transmitted(lobe, view).wi;
                EXPECT_NEAR(std::hypot(ahead.x, ahead.y) * (isThin ? 1.0f : 1.5f), std::hypot(wo.x, wo.y),
                            1e-5f);
            }
        }
    }
}

// Returns the fraction that a layer transmits to its base towards wo.
float PlacedShareAt(const GltfBxDF& material, vec3 wo) {
    DielectricLayerBxDF layer{};
    float share = 1.0f;
    InitLobe(layer, material, material, ViewOf(material, wo), share);
    return share;
}

LoneLobe<DielectricLayerBxDF> Layer(const GltfBxDF& material, vec3 wo) {
    return {PlacedLobe<DielectricLayerBxDF>(material, wo), material};
}

TEST(DielectricLayer, SampledDirectionsFollowPDF) {
    for (const float alpha : {0.1f, 0.6f}) {
        const vec3 wo = DirectionAt(0.5f, 0.6f);
        const LobePart part{PolarGrid::About(vec3(-wo.x, -wo.y, wo.z), alpha)};
        const test::ChiSquareResult result = ChiSquareOfLobe(Layer(GltfLobe(alpha), wo), wo, {part}, 6000);
        EXPECT_GT(result.degreesOfFreedom, 50) << alpha;
        EXPECT_GT(result.pValue, test::SidakLevel(0.01, 2)) << alpha;
        ExpectSamplesAgree(Layer(GltfLobe(alpha), wo), wo, 2e-4f);
    }
}

// This holds however dim it is: of facets whose reflectance rises from 0, nearly all light that a viewer sees
// from above has met two.
TEST(DielectricLayer, DimFacetsReflectLaterBouncesToo) {
    for (const float specular : {1.0f, 0.03f, 1e-3f, 0.0f}) {
        GltfBxDF material = GltfLobe(1.0f);
        material.specular = specular;
        material.specularColor = vec3(0.0f, 1.0f, 0.5f);
        const vec3 wo = DirectionAt(0.95f, 0.6f);
        const FacetView view = ViewOf(material, wo);
        const FacetFresnel fresnel = DielectricFresnel(material);
        const vec3 all = FacetAlbedo(view, view.energy, fresnel.f0, fresnel.f90);
        const vec3 stated = Reflected(PlacedLobe<DielectricLayerBxDF>(material, wo), view).albedo;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(stated[c], all[c], 1e-5f * all[c]) << specular << " " << c;
    }
}

// The layer scales all channels equally: a colored layer would otherwise give its base the inverse color.
TEST(DielectricLayer, PassesWhatTheChannelReflectedMostLeaves) {
    for (const vec3 tint : {vec3(0.0f, 1.0f, 0.5f), vec3(1.0f, 0.5f, 0.0f), vec3(0.5f, 0.0f, 1.0f)}) {
        GltfBxDF material = GltfLobe(0.6f);
        material.eta = 2.5f;
        material.specularColor = tint;
        const vec3 wo = DirectionAt(0.7f, 0.6f);
        const vec3 reflected =
            Reflected(PlacedLobe<DielectricLayerBxDF>(material, wo), ViewOf(material, wo)).albedo;
        const float most = std::max({reflected.x, reflected.y, reflected.z});
        EXPECT_GT(most, 0.1f);
        EXPECT_NEAR(PlacedShareAt(material, wo), 1.0f - most, 1e-4f);
    }
}

// The base does not receive what the layer reflects; light to and from the base is attenuated equally.
TEST(DielectricLayer, LightThatItPassesIsWhatItDoesNotReflect) {
    for (const MultiscatterKind kind : {MultiscatterKind::Off, MultiscatterKind::Lut}) {
        const MultiscatterScope scope(kind);
        for (const float alpha : {0.0f, 0.3f, 0.9f}) {
            for (const float cosine : {0.9f, 0.2f}) {
                GltfBxDF material = GltfLobe(alpha);
                material.metallic = 0.25f;
                const vec3 wo = DirectionAt(cosine, 0.6f);
                const FacetView view = ViewOf(material, wo);
                DielectricLayerBxDF layer{};
                float share = 1.0f;
                InitLobe(layer, material, material, view, share);
                const double reflected = Reflected(layer, view).albedo.x;
                EXPECT_NEAR(share, 0.75 - reflected, 1e-4) << "alpha " << alpha << " cos " << cosine;
                if (alpha > 0.0f) {
                    const Estimate sampled = EstimateAlbedo(Layer(material, wo), wo, 37);
                    EXPECT_NEAR(reflected, sampled.mean, 5.0 * sampled.error + 1e-3) << alpha;
                }
                const auto passed = [&](float cosI) {
                    return NormalizedTransmittance(layer, view, PairOf(view, DirectionAt(cosI, 0.0f), false));
                };
                EXPECT_NEAR(passed(cosine) / passed(1.0f),
                            share / PlacedShareAt(material, DirectionAt(1.0f, 0.6f)), 1e-4);
                double mean = 0.0;
                constexpr int kPoints = 1000;
                for (int i = 0; i < kPoints; ++i)
                    mean += static_cast<double>(passed(std::sqrt((static_cast<float>(i) + 0.5f) / kPoints))) /
                            kPoints;
                EXPECT_NEAR(mean, 1.0, 5e-3) << "alpha " << alpha;
            }
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::dielectric_test
