// Microfacets, and the lobes that they make: conductor, glass, and the layer of a dielectric.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "tests/shading/gltf_lobe.h"
#include "tests/shading/lobe_checks.h"
#include "tests/support/reference_assets.h"

// Surfaces and viewers over which microfacet lobes are tested.
namespace raygraph::shading {

inline constexpr std::array kMaskingModels = {MaskingModel::Correlated, MaskingModel::Separable,
                                              MaskingModel::Shortcut};

// The models of this thread, for a scope.
class ScopedModels {
  public:
    explicit ScopedModels(MicrofacetModel distribution, MaskingModel masking = MaskingModel::Correlated,
                          FresnelModel fresnel = FresnelModel::Schlick) {
        threadMicrofacetModel = distribution;
        threadMaskingModel = masking;
        threadFresnelModel = fresnel;
    }
    ~ScopedModels() {
        threadMicrofacetModel = MicrofacetModel::Ggx;
        threadMaskingModel = MaskingModel::Correlated;
        threadFresnelModel = FresnelModel::Schlick;
    }
    ScopedModels(const ScopedModels&) = delete;
    ScopedModels& operator=(const ScopedModels&) = delete;
};

struct MicrofacetCase {
    MicrofacetModel distribution;
    vec2 alpha;
    vec3 wo;
};

inline std::ostream& operator<<(std::ostream& out, const MicrofacetCase& c) {
    return out << "distribution " << static_cast<int>(c.distribution) << ", alpha (" << c.alpha.x << ", "
               << c.alpha.y << "), cos " << c.wo.z;
}

// Alpha is the square of the roughness.
inline std::vector<MicrofacetCase> MicrofacetCases(bool isLong) {
    std::vector<MicrofacetCase> cases;
    const auto add = [&](MicrofacetModel distribution, float x, float y, float cosTheta, float phi) {
        cases.push_back({distribution, vec2(x, y), DirectionAt(cosTheta, phi)});
    };
    if (isLong) {
        for (auto distribution : {MicrofacetModel::Ggx, MicrofacetModel::Beckmann, MicrofacetModel::Phong}) {
            for (float roughness : {0.05f, 0.1f, 0.25f, 0.5f, 0.75f, 1.0f}) {
                const float alpha = roughness * roughness;
                for (float cosTheta : {1.0f, 0.7f, 0.3f, 0.05f, -0.5f})
                    add(distribution, alpha, alpha, cosTheta, 1.0f);
            }
            for (float cosTheta : {0.9f, 0.4f, -0.1f}) {
                add(distribution, 0.09f, 0.5f, cosTheta, 0.6f);
                add(distribution, 0.8f, 0.25f, cosTheta, 2.0f);
            }
        }
        return cases;
    }
    for (float roughness : {0.05f, 0.3f, 0.6f, 1.0f})
        for (float cosTheta : {0.8f, 0.05f})
            add(MicrofacetModel::Ggx, roughness * roughness, roughness * roughness, cosTheta, 1.0f);
    add(MicrofacetModel::Ggx, 0.25f, 0.25f, 1.0f, 0.0f);
    add(MicrofacetModel::Ggx, 0.25f, 0.25f, -0.4f, 4.0f);
    add(MicrofacetModel::Ggx, 0.1f, 0.5f, 0.6f, 0.6f);
    add(MicrofacetModel::Ggx, 0.8f, 0.25f, 0.1f, 2.0f);
    for (auto distribution : {MicrofacetModel::Beckmann, MicrofacetModel::Phong}) {
        add(distribution, 0.0025f, 0.0025f, 0.7f, 1.0f);
        add(distribution, 0.25f, 0.25f, 0.9f, 1.0f);
        add(distribution, 0.25f, 0.25f, 0.1f, 1.0f);
        add(distribution, 1.0f, 1.0f, 0.5f, 1.0f);
        add(distribution, 0.25f, 0.7f, -0.6f, 2.0f);
    }
    return cases;
}

}  // namespace raygraph::shading

namespace raygraph::shading::microfacet_test {
namespace {

constexpr std::array kDistributions = {MicrofacetModel::Ggx, MicrofacetModel::Beckmann,
                                       MicrofacetModel::Phong};
const std::array kAlphas = {vec2(0.0025f, 0.0025f), vec2(0.1f, 0.1f),  vec2(0.5f, 0.5f),
                            vec2(1.0f, 1.0f),       vec2(0.15f, 0.6f), vec2(0.9f, 0.3f)};

// A grid on which functions of the normal are smooth.
PolarGrid NormalGrid(vec2 alpha) {
    const float least = std::min(alpha.x, alpha.y);
    return least >= 0.2f ? PolarGrid{} : PolarGrid::About(vec3(0.0f, 0.0f, 1.0f), least);
}

double IntegrateOverNormals(vec2 alpha, const Density& density) {
    return NormalGrid(alpha).IntegrateSum([&](vec3 wm) { return wm.z > 0.0f ? density(wm) : 0.0; });
}

TEST(Microfacet, FacetsProjectToTheSurface) {
    for (MicrofacetModel distribution : kDistributions) {
        const ScopedModels models(distribution);
        for (vec2 alpha : kAlphas) {
            const MicrofacetDistribution d = MakeMicrofacetDistribution(alpha);
            const double area =
                IntegrateOverNormals(alpha, [&](vec3 wm) { return static_cast<double>(D(d, wm) * wm.z); });
            EXPECT_NEAR(area, 1.0, 1e-3)
                << static_cast<int>(distribution) << " " << alpha.x << " " << alpha.y;
        }
    }
}

// Smith: the visible facets cover what the viewer sees of the surface, int D G1 max(0, wo.wm) = cos. Exact
// for GGX; for Beckmann to Walter's fit of Lambda; for Phong to our fit.
TEST(Microfacet, VisibleFacetsProjectToWhatTheViewerSees) {
    const std::array tolerances = {1e-3, 4e-3, 4e-2};
    for (size_t i = 0; i < kDistributions.size(); ++i) {
        const ScopedModels models(kDistributions[i]);
        for (vec2 alpha : kAlphas) {
            const MicrofacetDistribution d = MakeMicrofacetDistribution(alpha);
            for (float cosTheta : {1.0f, 0.8f, 0.4f, 0.1f}) {
                const vec3 wo = DirectionAt(cosTheta, 0.7f);
                const double seen = IntegrateOverNormals(alpha, [&](vec3 wm) {
                    return static_cast<double>(D(d, wm) * G1(d, wo) * std::max(dot(wo, wm), 0.0f));
                });
                EXPECT_NEAR(seen / static_cast<double>(cosTheta), 1.0, tolerances[i])
                    << "distribution " << i << ", alpha " << alpha.x << " " << alpha.y << ", cos "
                    << cosTheta;
            }
        }
    }
}

TEST(Microfacet, SampledNormalsFollowPDF) {
    struct Case {
        vec2 alpha;
        float cosTheta;
    };
    const std::array cases = {Case{vec2(0.0025f, 0.0025f), 0.5f}, Case{vec2(0.5f, 0.5f), 0.05f},
                              Case{vec2(1.0f, 1.0f), 0.6f}, Case{vec2(0.15f, 0.6f), 0.3f}};
    constexpr int kSampleCount = 300'000;
    const double level = test::SidakLevel(0.01, static_cast<int>(cases.size() * kDistributions.size()));
    uint32_t seed = 3000;
    for (MicrofacetModel distribution : kDistributions) {
        const ScopedModels models(distribution);
        for (const Case& c : cases) {
            const MicrofacetDistribution d = MakeMicrofacetDistribution(c.alpha);
            const vec3 wo = DirectionAt(c.cosTheta, 0.7f);
            const PolarGrid grid = NormalGrid(c.alpha);
            std::vector<double> observed(grid.CellCount(), 0.0);
            Uniform uniform(seed++);
            for (int i = 0; i < kSampleCount; ++i) {
                const vec3 wm = Sample_wm(d, wo, uniform.Pair());
                observed[grid.Cell(wm)] += 1.0;
            }
            std::vector<double> expected = grid.Integrate(
                [&](vec3 wm) { return wm.z > 0.0f ? static_cast<double>(PDF(d, wo, wm)) : 0.0; });
            for (double& share : expected) share = std::max(share, 1e-8) * kSampleCount;
            const test::ChiSquareResult result = test::ChiSquareTest(observed, expected);
            EXPECT_GT(result.degreesOfFreedom, 100);
            EXPECT_GT(result.pValue, level)
                << "distribution " << static_cast<int>(distribution) << ", alpha " << c.alpha.x << " "
                << c.alpha.y << ", cos " << c.cosTheta << ", chi-squared " << result.statistic << " of "
                << result.degreesOfFreedom;
        }
    }
}

TEST(Microfacet, MaskingIsAShareAndFallsFromCorrelatedToSeparable) {
    Uniform uniform(5);
    for (MicrofacetModel distribution : kDistributions) {
        for (vec2 alpha : kAlphas) {
            const MicrofacetDistribution d = MakeMicrofacetDistribution(alpha);
            for (int i = 0; i < 300; ++i) {
                const vec3 wo = uniform.Direction();
                const vec3 wi = uniform.Direction();
                const bool isReflection = SameHemisphere(wo, wi);
                const vec3 wm = isReflection ? ReflectionNormal(wo, wi) : RefractionNormal(wo, wi, 1.5f);
                std::array<float, 3> shares{};
                for (size_t m = 0; m < kMaskingModels.size(); ++m) {
                    const ScopedModels models(distribution, kMaskingModels[m]);
                    shares[m] = G(d, wo, wi, wm);
                    ASSERT_GE(shares[m], 0.0f);
                    ASSERT_LE(shares[m], 1.00002f);
                    ASSERT_NEAR(shares[m], G(d, wi, wo, wm), 1e-5f);
                    const bool isSmith = kMaskingModels[m] != MaskingModel::Shortcut;
                    ASSERT_TRUE(!isSmith || shares[m] <= 1.00002f * std::min(G1(d, wo), G1(d, wi)));
                }
                // Heights correlate on one side of the surface, and anticorrelate across it.
                const float sign = isReflection ? 1.0f : -1.0f;
                ASSERT_GE(sign * (shares[0] - shares[1]), -1e-5f * shares[1]);
            }
        }
    }
}

TEST(Microfacet, ShareSeenFromBothSidesIsEulersBetaFunction) {
    for (float a : {0.0f, 0.01f, 0.3f, 1.0f, 4.0f, 30.0f}) {
        for (float b : {0.0f, 0.02f, 0.7f, 2.0f, 11.0f}) {
            const double exact = std::beta(1.0 + static_cast<double>(a), 1.0 + static_cast<double>(b));
            EXPECT_NEAR(BetaOnePlus(a, b) / exact, 1.0, 3e-5) << a << " " << b;
        }
    }
}

TEST(Microfacet, FacetsSeenFromTheirBackAreMasked) {
    const MicrofacetDistribution d = MakeMicrofacetDistribution(vec2(0.5f, 0.5f));
    const vec3 wm = DirectionAt(0.6f, 0.0f);
    const vec3 away = DirectionAt(0.1f, 3.14159f);
    EXPECT_EQ(G(d, away, wm, wm), 0.0f);
    EXPECT_EQ(G(d, wm, away, wm), 0.0f);
    EXPECT_GT(G(d, wm, wm, wm), 0.0f);
}

// Straight down, where the tangent is 0, on the horizon, where it is infinite, and beyond a cosine of 1.
TEST(Microfacet, ExtremeDirectionsGiveFiniteValues) {
    const std::array directions = {vec3(0.0f, 0.0f, 1.0f), vec3(0.0f, 0.0f, 1.000001f),
                                   DirectionAt(1e-6f, 1.0f), vec3(1.0f, 0.0f, 1e-20f),
                                   DirectionAt(0.5f, 2.0f)};
    const float last = 1.0f - 0x1p-24f;
    for (MicrofacetModel distribution : kDistributions) {
        for (MaskingModel masking : kMaskingModels) {
            const ScopedModels models(distribution, masking);
            for (vec2 alpha : {vec2(1e-3f, 1e-3f), vec2(0.3f, 0.3f), vec2(1.0f, 1.0f), vec2(0.0f, 1.0f)}) {
                const MicrofacetDistribution d = MakeMicrofacetDistribution(alpha);
                for (vec3 wo : directions) {
                    EXPECT_TRUE(std::isfinite(D(d, wo)));
                    EXPECT_TRUE(std::isfinite(Lambda(d, wo)));
                    EXPECT_TRUE(G1(d, wo) >= 0.0f && G1(d, wo) <= 1.0f);
                    for (vec3 wi : directions) {
                        const vec3 wm = ReflectionNormal(wo, wi);
                        EXPECT_TRUE(std::isfinite(G(d, wo, wi, wm)));
                        EXPECT_TRUE(std::isfinite(ReflectionPDF(d, wo, wm)));
                    }
                    for (vec2 u : {vec2(0.0f, 0.0f), vec2(last, 0.0f), vec2(0.0f, last), vec2(last, last),
                                   vec2(last, 0.5f), vec2(0.5f, 0.25f)}) {
                        const vec3 wm = Sample_wm(d, wo, u);
                        EXPECT_NEAR(length(wm), 1.0f, 1e-5f);
                        EXPECT_GE(wm.z, 0.0f);
                        EXPECT_TRUE(std::isfinite(PDF(d, wo, wm)));
                    }
                }
            }
        }
    }
    EXPECT_EQ(G1(MakeMicrofacetDistribution(vec2(0.5f, 0.5f)), vec3(1.0f, 0.0f, 0.0f)), 0.0f);
    EXPECT_EQ(ReflectionNormal(vec3(0.0f, 0.6f, 0.8f), vec3(0.0f, -0.6f, -0.8f)), vec3(0.0f));
}

TEST(Microfacet, SmallAlphaIsSmooth) {
    EXPECT_TRUE(IsEffectivelySmooth(MakeMicrofacetDistribution(vec2(9.9e-4f, 0.0f))));
    EXPECT_FALSE(IsEffectivelySmooth(MakeMicrofacetDistribution(vec2(1e-3f, 0.0f))));
    EXPECT_EQ(MakeMicrofacetDistribution(vec2(0.5f, 0.0f)).alpha, vec2(0.5f, kSmoothAlpha));
}

TEST(Microfacet, RefractionFollowsSnell) {
    Uniform uniform(9);
    for (float eta : {1.1f, 1.5f, 2.4f, 1.0f / 1.5f}) {
        for (int i = 0; i < 1000; ++i) {
            const vec3 wm = uniform.Direction();
            const vec3 wo = uniform.Direction();
            if (dot(wo, wm) <= 0.01f) continue;
            vec3 wi;
            const float sinI = length(cross(wo, wm));
            const bool isRefracted = Refract(wo, wm, eta, wi);
            ASSERT_EQ(isRefracted, sinI < eta) << sinI;
            if (!isRefracted) continue;
            ASSERT_LT(dot(wi, wm), 0.0f);
            ASSERT_NEAR(length(cross(wi, wm)) * eta, sinI, 2e-6f * eta);
            ASSERT_NEAR(dot(cross(wo, wi), wm), 0.0f, 2e-6f);
            ASSERT_GT(std::abs(dot(RefractionNormal(wo, wi, eta), wm)), 0.9999f);
        }
    }
}

// The albedo of white GGX metal, against numbers from elsewhere.
TEST(Microfacet, WhiteGgxMetalHasTheReferenceAlbedo) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    std::ifstream file(*test::ReferenceAssets() / "references/ggx_white_metal_albedo.json");
    ASSERT_TRUE(file.good());
    const nlohmann::json table = nlohmann::json::parse(file);
    ASSERT_EQ(table.size(), 25u);
    for (const auto& [key, columns] : table.items()) {
        float roughness = 0.0f;
        float cosTheta = 0.0f;
        ASSERT_EQ(std::sscanf(key.c_str(), "%f,%f", &roughness, &cosTheta), 2);
        const MicrofacetDistribution d =
            MakeMicrofacetDistribution(vec2(roughness * roughness, roughness * roughness));
        const vec3 wo = DirectionAt(cosTheta, 0.0f);
        const vec3 mirror(-wo.x, -wo.y, wo.z);
        const PolarGrid grid = roughness < 0.45f ? PolarGrid::About(mirror, 0.1f) : PolarGrid{};
        for (MaskingModel masking : {MaskingModel::Correlated, MaskingModel::Separable}) {
            const ScopedModels models(MicrofacetModel::Ggx, masking);
            const double albedo = grid.IntegrateSum([&](vec3 wi) {
                if (wi.z <= 0.0f) return 0.0;
                return static_cast<double>(ReflectionLobe(d, wo, wi, ReflectionNormal(wo, wi)) * wi.z);
            });
            const double reference =
                columns[masking == MaskingModel::Correlated ? "corr" : "sep"].get<double>();
            EXPECT_NEAR(albedo / reference, 1.0, 3e-3) << key << " masking " << static_cast<int>(masking);
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::microfacet_test

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

// Glass, and the layer of a dielectric over an opaque base.
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
