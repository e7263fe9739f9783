// Stretched highlights: what the extension says of their roughness, their frame, and the energy of facets for
// which there is no table.
#include "tests/shading/gltf_lobe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "bxdf/bsdf.glsl"

namespace raygraph::shading::anisotropy_test {
namespace {

SurfaceMaterial Brushed(float strength, float roughness) {
    SurfaceMaterial material{};
    material.roughness = roughness;
    material.anisotropy = strength;
    material.ior = 1.5f;
    return material;
}

GltfBxDF Stretched(GltfBxDF lobe, float strength, float roughness) {
    lobe.alpha = SettingOf(Brushed(strength, roughness), 1.5f, 0.0f, 0u).alpha;
    return lobe;
}

// Strengths, roughnesses, angles and azimuths to the direction of the stretch.
template <typename Check>
void ForEachStretch(Check&& check) {
    for (const float strength : {0.25f, 0.6f, 1.0f})
        for (const float roughness : {0.1f, 0.3f, 0.7f})
            for (const float cosine : {1.0f, 0.6f, 0.2f, 0.05f})
                for (const float azimuth : {0.0f, 0.8f, 1.57f}) {
                    SCOPED_TRACE("strength " + std::to_string(strength) + " roughness " +
                                 std::to_string(roughness) + " cos " + std::to_string(cosine) + " azimuth " +
                                 std::to_string(azimuth));
                    check(strength, roughness, DirectionAt(cosine, azimuth));
                    if (cosine == 1.0f) break;
                }
}

uint SampleCount() {
    return AreTestsLong() ? 1u << 15 : 1u << 11;
}

TEST(Anisotropy, RoughnessGrowsAlongTheDirectionByTheSquareOfTheStrength) {
    // mix(alpha, 1, strength^2) and alpha
    EXPECT_EQ(AlphaOf(Brushed(0.0f, 0.5f)), vec2(0.25f));
    EXPECT_NEAR(AlphaOf(Brushed(0.6f, 0.5f)).x, 0.25f + 0.36f * 0.75f, 1e-6f);
    EXPECT_EQ(AlphaOf(Brushed(0.6f, 0.5f)).y, 0.25f);
    EXPECT_EQ(AlphaOf(Brushed(1.0f, 0.1f)).x, 1.0f);
    const SurfaceSetting regularized = SettingOf(Brushed(0.6f, 0.5f), 1.5f, 0.3f, 0u);
    EXPECT_NEAR(regularized.alpha.x, 0.52f, 1e-6f);
    EXPECT_EQ(regularized.alpha.y, 0.3f);
}

// Rough along one direction is not smooth: no wall is a hole then, and no reflection a mirror.
TEST(Anisotropy, StretchedMirrorIsNoMirror) {
    SurfaceMaterial wall = Brushed(0.3f, 0.0f);
    wall.transmission = 1.0f;
    EXPECT_FALSE(IsSmoothThinWall(wall));
    wall.anisotropy = 0.02f;  // alpha 0.0004
    EXPECT_TRUE(IsSmoothThinWall(wall));
    const GltfBxDF metal = Stretched(Metal(0.0f), 0.3f, 0.0f);
    EXPECT_EQ(Flags(metal), kBxDFReflection | kBxDFGlossy);
    // Light is spread along x alone
    Uniform uniform(3);
    const vec3 wo = DirectionAt(0.8f, 0.5f);
    double along = 0.0, across = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const BSDFSample s = Sample_f(metal, wo, 0.5f, uniform.Pair());
        if (s.pdf == 0.0f) continue;
        const vec3 h = normalize(wo + s.wi);
        along += std::abs(double{h.x / h.z});
        across += std::abs(double{h.y / h.z});
    }
    EXPECT_GT(along, 20.0 * across);
}

TEST(Anisotropy, FrameHasItsXAxisAlongTheStretch) {
    Uniform uniform(9);
    for (int i = 0; i < 1000; ++i) {
        SurfaceInteraction surface{};
        surface.shadingNormal = uniform.Direction();
        surface.stretch = (0.01f + 50.0f * uniform()) * uniform.Direction();
        const Frame frame = FrameOf(surface);
        EXPECT_EQ(frame.z, surface.shadingNormal);
        EXPECT_LT(length(cross(frame.x, frame.y) - frame.z), 1e-5f);
        EXPECT_NEAR(length(frame.x), 1.0f, 1e-5f);
        const float sine = length(cross(surface.stretch, frame.z)) / length(surface.stretch);
        if (sine < 0.05f) continue;
        EXPECT_NEAR(dot(surface.stretch, frame.y) / length(surface.stretch), 0.0f, 2e-5f);
        EXPECT_NEAR(dot(surface.stretch, frame.x) / length(surface.stretch), sine, 2e-5f);
    }
    // Without a tangent, or with none in the surface, the highlight is round
    SurfaceInteraction surface{};
    surface.shadingNormal = DirectionAt(0.3f, 2.0f);
    for (const float scale : {0.0f, 7.0f}) {
        surface.stretch = scale * surface.shadingNormal;
        EXPECT_EQ(FrameOf(surface).x, FrameFromZ(surface.shadingNormal).x) << scale;
    }
}

// One bounce by few facets is on average what a dense lattice of them gives, and each estimate is near.
TEST(Anisotropy, EstimatesOfOneBounceHaveItAsTheirMean) {
    constexpr uint kSeeds = 400;
    ForEachStretch([](float strength, float roughness, vec3 wo) {
        const vec2 alpha = Stretched(Metal(0.0f), strength, roughness).alpha;
        glm::dvec2 exact(0.0);
        constexpr int kSide = 150;
        for (int i = 0; i < kSide * kSide; ++i) {
            const vec3 wm =
                SampleVisibleFacet(alpha, wo, (vec2(i / kSide, i % kSide) + vec2(0.5f)) / float(kSide));
            const vec3 wi = Reflect(wo, wm);
            if (!(wi.z > 0.0f)) continue;
            const float curve = SchlickWeight(dot(wo, wm));
            // G2 / G1
            const MicrofacetDistribution d{.alpha = alpha};
            const double leaves = double{GOverCosines(d, wo, wi) * wo.z * wi.z / G1(d, wo)};
            exact += leaves * glm::dvec2(1.0 - curve, curve) / double(kSide * kSide);
        }
        glm::dvec2 sum(0.0);
        double square = 0.0;
        for (uint seed = 0; seed < kSeeds; ++seed) {
            const FacetEnergy energy = EstimateFacets(alpha, wo, MixBits(seed));
            sum += glm::dvec2(energy.single) / double(kSeeds);
            square += std::pow(double{energy.single.x + energy.single.y} - exact.x - exact.y, 2.0) / kSeeds;
            ASSERT_NEAR(energy.second, 1.0f - energy.single.x - energy.single.y, 1e-5f);
            ASSERT_LE(energy.curveProduct, energy.curveMean + 1e-6f);
        }
        EXPECT_NEAR(sum.x, exact.x, 5e-3);
        EXPECT_NEAR(sum.y, exact.y, 5e-3);
        EXPECT_LT(std::sqrt(square), 0.05);
    });
}

// White surfaces are as white as round ones are by the tables (Energy.TablesReturnAllLight), whichever way
// they are turned. By one table row for the mean of the two alphas they would lose up to 47 %.
TEST(Anisotropy, WhiteIsWhiteAtEveryAzimuth) {
    const std::pair<const char*, GltfBxDF> kWhite[] = {{"metal", Metal(0.0f)},
                                                       {"dielectric", GltfLobe(0.0f)},
                                                       {"thin wall", ThinGlass(0.0f)},
                                                       {"glass from outside", Glass(0.0f, 1.5f)},
                                                       {"glass from inside", Glass(0.0f, 1.0f / 1.5f)},
                                                       {"diamond from inside", Glass(0.0f, 1.0f / 2.42f)}};
    ForEachStretch([&](float strength, float roughness, vec3 wo) {
        for (const auto& [name, lobe] : kWhite)
            EXPECT_NEAR(MeasureAlbedo(Stretched(lobe, strength, roughness), wo, SampleCount()).Sum().y, 1.0,
                        0.02)
                << name;
    });
}

// The albedo of colored light on each side of glass is the simulated one.
TEST(Anisotropy, AlbedoIsThatOfWalks) {
    GltfBxDF layer = GltfLobe(0.0f);
    layer.baseColor = vec3(0.0f);
    layer.specularColor = vec3(1.0f, 4.0f, 16.0f);
    struct Case {
        const char* name;
        GltfBxDF lobe;
        double bound;
    };
    const Case kCases[] = {{"metal", Metal(0.0f, vec3(0.2f, 0.5f, 0.9f)), 0.02},
                           {"layer", layer, 0.02},
                           {"glass from outside", Glass(0.0f, 1.5f), 0.08},
                           {"glass from inside", Glass(0.0f, 1.0f / 1.5f), 0.12}};
    ForEachStretch([&](float strength, float roughness, vec3 wo) {
        for (const Case& test : kCases) {
            const GltfBxDF lobe = Stretched(test.lobe, strength, roughness);
            Albedo walk;
            {
                const MultiscatterScope scope(MultiscatterKind::Walk);
                walk = MeasureAlbedo(lobe, wo, SampleCount());
            }
            const Albedo lut = MeasureAlbedo(lobe, wo, SampleCount());
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(lut.reflected[c], walk.reflected[c], test.bound) << test.name << ' ' << c;
                EXPECT_NEAR(lut.transmitted[c], walk.transmitted[c], test.bound) << test.name << ' ' << c;
            }
        }
    });
}

TEST(Anisotropy, WalksReturnAllLight) {
    const MultiscatterScope scope(MultiscatterKind::Walk);
    ForEachStretch([](float strength, float roughness, vec3 wo) {
        for (const GltfBxDF& lobe : {Metal(0.0f), Glass(0.0f, 1.5f), Glass(0.0f, 1.0f / 1.5f)})
            EXPECT_NEAR(MeasureAlbedo(Stretched(lobe, strength, roughness), wo, SampleCount()).Sum().y, 1.0,
                        0.01);
    });
}

// The largest ratio of f one way to f the other way.
double WorstRatio(const GltfBxDF& lobe) {
    std::mt19937 generator(23);
    const auto unit = [&] { return static_cast<float>(generator() >> 8) * 0x1p-24f; };
    double worst = 1.0;
    for (int i = 0; i < 10'000; ++i) {
        const vec3 a = DirectionAt(0.02f + 0.98f * unit(), 6.2831f * unit());
        const vec3 b = DirectionAt(0.02f + 0.98f * unit(), 6.2831f * unit());
        const double forth = f(lobe, a, b).y, back = f(lobe, b, a).y;
        if (std::max(forth, back) > 1e-5) worst = std::max({worst, forth / back, back / forth});
    }
    return worst;
}

// One bounce is reciprocal. With later ones a factor of wo's, azimuth and all, makes f differ from its reverse
// by the ratio of two such: the bounds that the documentation states.
TEST(Anisotropy, IsReciprocalButForTheLightOfLaterBounces) {
    {
        const MultiscatterScope scope(MultiscatterKind::Off);
        EXPECT_LT(WorstRatio(Stretched(Metal(0.0f), 0.8f, 0.2f)), 1.001);
        EXPECT_LT(WorstRatio(Stretched(Metal(0.0f), 1.0f, 0.1f)), 1.001);
    }
    EXPECT_LT(WorstRatio(Stretched(Metal(0.0f), 0.5f, 0.3f)), 1.6);
    EXPECT_LT(WorstRatio(Stretched(Metal(0.0f), 1.0f, 0.3f)), 2.6);
    EXPECT_LT(WorstRatio(Stretched(GltfLobe(0.0f), 1.0f, 0.3f)), 1.4);
    EXPECT_GT(WorstRatio(Stretched(Metal(0.0f), 1.0f, 0.3f)), 1.1) << "the bounds are of something";
}

// The normals of AnisotropySampleOf are those of the stretch: the mean square tilt along x of what they reflect is that
// of samples, and none is across. Round facets have one direction, which is that without a stretch.
TEST(Anisotropy, PartsOfAStretchedReflectionLieAlongIt) {
    const vec3 up(0.0f, 0.0f, 1.0f);
    constexpr uint kParts = 16;
    for (const float strength : {0.0f, 0.4f, 0.8f}) {
        const GltfBxDF lobe = Stretched(Metal(0.0f), strength, 0.2f);
        double parts = 0.0, weights = 0.0, samples = 0.0, all = 0.0;
        for (uint i = 0; i < kParts; ++i) {
            const AnisotropySample part = AnisotropySampleOf(lobe.alpha, up, i, kParts);
            EXPECT_NEAR(part.wi.y, 0.0f, 1e-6f);
            parts += double{part.weight} * std::abs(double{part.wi.x});
            weights += double{part.weight};
        }
        Uniform uniform(31);
        for (int i = 0; i < 20'000; ++i) {
            const BSDFSample s = Sample_f(lobe, up, 0.5f, uniform.Pair());
            if (s.pdf == 0.0f) continue;
            const double weight = double{s.f.x * s.wi.z / s.pdf};
            samples += weight * std::abs(double{s.wi.x});
            all += weight;
        }
        EXPECT_NEAR(parts / weights, strength == 0.0f ? 0.0 : samples / all, 0.05 + 0.1 * samples / all)
            << strength;
    }
    const vec3 wo = DirectionAt(0.6f, 1.0f);
    EXPECT_LT(
        length(AnisotropySampleOf(vec2(0.3f), wo, 3u, kParts).wi - DominantReflection(wo, std::sqrt(0.3f))),
        1e-5f);
}

}  // namespace
}  // namespace raygraph::shading::anisotropy_test
