#include "bxdf/microfacet.glsl"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/shading/lobe_checks.h"
#include "tests/shading/microfacet_cases.h"
#include "tests/support/reference_assets.h"

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
    constexpr int kSampleCount = 1'000'000;
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
