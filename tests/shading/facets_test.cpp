// Facets beyond one bounce and one direction: stretched highlights, retroreflection, and walks among facets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/shading/gltf_lobe.h"

// Stretched highlights: what the extension says of their roughness, their frame, and the energy of facets for
// which there is no table.
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
    for (const float strength : {0.4f, 1.0f})
        for (const float roughness : {0.1f, 0.3f, 0.7f})
            for (const float cosine : {1.0f, 0.5f, 0.05f})
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

// Facets that reflect light back: the reflection of a viewer mirrored about the normal, and nothing else.
namespace raygraph::shading::retroreflection_test {
namespace {

GltfBxDF Back(GltfBxDF lobe, float share) {
    lobe.retroreflection = share;
    return lobe;
}

GltfBxDF Brushed() {
    GltfBxDF lobe = Metal(0.3f, vec3(1.0f, 0.7f, 0.3f));
    lobe.alpha.x = 0.7f;
    return lobe;
}

GltfBxDF BlackLayer(float alpha) {
    GltfBxDF lobe = GltfLobe(alpha);
    lobe.baseColor = vec3(0.0f);
    return lobe;
}

struct Surface {
    const char* name;
    GltfBxDF lobe;
};
const Surface kSurfaces[] = {{"metal", Metal(0.3f, vec3(1.0f, 0.7f, 0.3f))},
                             {"brushed metal", Brushed()},
                             {"layer", BlackLayer(0.4f)},
                             {"plastic", GltfLobe(0.5f)},
                             {"glass", Glass(0.4f, 1.5f)},
                             {"glass from within", Glass(0.4f, 1.0f / 1.5f)},
                             {"thin wall", ThinGlass(0.4f)},
                             {"all of it", Blend(0.5f)}};

vec3 AboveOf(Uniform& uniform) {
    vec3 w = uniform.Direction();
    w.z = std::max(std::abs(w.z), 0.02f);
    return normalize(w);
}

}  // namespace

TEST(Retroreflection, SampledDirectionsFollowPDF) {
    uint32_t seed = 6100;
    for (const Surface& surface : kSurfaces)
        for (const float share : {0.4f, 1.0f}) {
            if (share == 1.0f && surface.lobe.transmission == 0.0f) continue;
            const GltfBxDF lobe = Back(surface.lobe, share);
            const vec3 wo = DirectionAt(0.55f, 0.8f);
            const test::ChiSquareResult result =
                ChiSquareOfLobe(SeenFrom(lobe, wo), wo, {{PolarGrid{}}}, seed++);
            EXPECT_GT(result.degreesOfFreedom, 20) << surface.name;
            EXPECT_GT(result.pValue, 1e-4) << surface.name << ", share " << share;
            ExpectSamplesAgree(lobe, wo, 3e-4f, 500);
        }
}

// By definition, a fraction of the reflection to a mirrored viewer is added. The transmission does not
// change.
TEST(Retroreflection, IsTheReflectionForAMirroredViewer) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    Uniform uniform(5);
    for (const Surface& surface : kSurfaces) {
        if (surface.name == std::string("plastic") || surface.name == std::string("all of it")) continue;
        for (int i = 0; i < 200; ++i) {
            const vec3 wo = AboveOf(uniform), wi = AboveOf(uniform), below = -AboveOf(uniform);
            const vec3 ahead = f(surface.lobe, wo, wi), back = f(surface.lobe, Mirrored(wo), wi);
            const vec3 seen = f(Back(surface.lobe, 0.3f), wo, wi);
            for (int color = 0; color < 3; ++color)
                EXPECT_NEAR(seen[color], 0.7f * ahead[color] + 0.3f * back[color],
                            1e-4f * (1e-3f + seen[color]))
                    << surface.name;
            EXPECT_EQ(f(Back(surface.lobe, 0.3f), wo, below), f(surface.lobe, wo, below)) << surface.name;
        }
    }
}

TEST(Retroreflection, IsReciprocal) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    Uniform uniform(11);
    for (const Surface& surface : kSurfaces) {
        const GltfBxDF lobe = Back(surface.lobe, 0.6f);
        for (int i = 0; i < 200; ++i) {
            const vec3 wo = AboveOf(uniform), wi = AboveOf(uniform);
            const float forth = f(lobe, wo, wi).x;
            EXPECT_NEAR(f(lobe, wi, wo).x, forth, 2e-4f * (1e-3f + forth)) << surface.name;
        }
    }
}

// The reflection changes in direction, not in amount: white stays white.
TEST(Retroreflection, ReflectsAsMuchAsAhead) {
    for (const MultiscatterKind kind : {MultiscatterKind::Lut, MultiscatterKind::Walk}) {
        const MultiscatterScope scope(kind);
        for (const Surface& surface : kSurfaces)
            for (const float cosine : {0.9f, 0.3f}) {
                const vec3 wo = DirectionAt(cosine, 0.3f);
                const Albedo ahead = MeasureAlbedo(surface.lobe, wo, 1u << 13u);
                const Albedo back = MeasureAlbedo(Back(surface.lobe, 0.7f), wo, 1u << 13u);
                for (int color = 0; color < 3; ++color) {
                    EXPECT_NEAR(back.reflected[color], ahead.reflected[color], 0.02)
                        << surface.name << ", cos " << cosine << ", kind " << int(kind);
                    EXPECT_NEAR(back.transmitted[color], ahead.transmitted[color], 0.02)
                        << surface.name << ", cos " << cosine << ", kind " << int(kind);
                }
            }
        EXPECT_NEAR(MeasureAlbedo(Back(Metal(0.6f), 1.0f), DirectionAt(0.4f, 1.0f), 1u << 13u).Sum().x, 1.0,
                    0.015);
    }
}

// A smooth surface has two reflections, each with its own share of Fresnel's.
TEST(Retroreflection, SmoothOneReflectsAheadAndBack) {
    const vec3 wo = DirectionAt(0.6f, 0.5f);
    for (const GltfBxDF& lobe : {Back(Metal(0.0f, vec3(0.9f)), 0.25f), Back(ThinGlass(0.0f), 0.25f)}) {
        glm::dvec3 weights(0.0);  // ahead, back, through
        constexpr int kCount = 40'000;
        for (int i = 0; i < kCount; ++i) {
            const BSDFSample s = Sample_f(lobe, wo, (float(i) + 0.5f) / kCount, vec2(0.5f));
            ASSERT_GT(s.pdf, 0.0f);
            ASSERT_TRUE(IsSpecular(s.flags));
            const int way = s.wi.z < 0.0f ? 2 : distance(s.wi, wo) < 1e-5f ? 1 : 0;
            ASSERT_TRUE(way != 0 || distance(s.wi, Mirrored(wo)) < 1e-5f);
            weights[way] += double{s.f.x * std::abs(s.wi.z) / s.pdf} / kCount;
        }
        const double f0 = lobe.metallic > 0.0f ? 0.9 : 0.04;
        const double reflected = f0 + (1.0 - f0) * std::pow(1.0 - 0.6, 5.0);
        EXPECT_NEAR(weights.x, 0.75 * reflected, 2e-3);
        EXPECT_NEAR(weights.y, 0.25 * reflected, 2e-3);
        EXPECT_NEAR(weights.z, lobe.metallic > 0.0f ? 0.0 : 1.0 - reflected, 5e-3);
    }
}

TEST(Retroreflection, CoatAndSheenReflectAsBefore) {
    Uniform uniform(3);
    GltfBxDF coated = GltfLobe(0.5f);
    coated.specular = 0.0f;
    coated.clearcoat = 0.8f;
    coated.clearcoatRoughness = 0.4f;
    coated.coatAlpha = 0.16f;
    GltfBxDF velvet = GltfLobe(0.6f);
    velvet.specular = 0.0f;
    velvet.sheenColor = vec3(0.4f, 0.2f, 0.1f);
    velvet.sheenRoughness = 0.5f;
    for (const GltfBxDF& lobe : {coated, velvet})
        for (int i = 0; i < 50; ++i) {
            const vec3 wo = AboveOf(uniform), wi = AboveOf(uniform);
            EXPECT_NEAR(f(Back(lobe, 1.0f), wo, wi).x, f(lobe, wo, wi).x, 1e-6f);
        }
}

}  // namespace raygraph::shading::retroreflection_test

namespace raygraph::shading::multiscatter_walk_test {
namespace {

vec3 Direction(float cosTheta, float phi) {
    const float sinTheta = std::sqrt(1.0f - cosTheta * cosTheta);
    return vec3(sinTheta * std::cos(phi), sinTheta * std::sin(phi), cosTheta);
}

WalkSurface Surface(uint kind, vec2 alpha, float eta, float f0) {
    WalkSurface surface{};
    surface.alpha = alpha;
    surface.kind = kind;
    surface.eta = eta;
    surface.fresnel.f0 = vec3(f0);
    surface.fresnel.f90 = vec3(1.0f);
    surface.fresnel.isMetal = false;
    return surface;
}

struct Case {
    std::string name;
    WalkSurface surface{};
};

std::vector<Case> Cases(vec2 alpha) {
    return {{"mirror", Surface(kWalkAbsorbs, alpha, 1.5f, 1.0f)},
            {"reflector", Surface(kWalkAbsorbs, alpha, 1.5f, 0.4f)},
            {"glass from outside", Surface(kWalkRefracts, alpha, 1.5f, 0.04f)},
            {"glass from inside", Surface(kWalkRefracts, alpha, 1.0f / 1.5f, 0.04f)},
            {"diamond from inside", Surface(kWalkRefracts, alpha, 1.0f / 2.42f, 0.172f)},
            {"thin wall", Surface(kWalkPassesThin, alpha, 1.5f, 0.04f)}};
}

const std::vector<vec2> kAlphas = {vec2(0.1f, 0.1f), vec2(0.5f, 0.5f), vec2(1.0f, 1.0f), vec2(0.8f, 0.2f)};

// The shader's head states that energy is lost to the bounce limit alone: less than 1e-4 for a reflector and
// 1e-3 for a dielectric.
TEST(MultiscatterWalk, TruncationLosesNoMoreThanStated) {
    constexpr uint kWalks = 100'000;
    for (const Case& c : Cases(vec2(1.0f, 1.0f))) {
        if (c.name == "reflector") continue;
        for (const float cosTheta : {1.0f, 0.3f, 0.01f}) {
            double sum = 0.0;
            for (uint i = 0; i < kWalks; ++i)
                sum += SampleWalk(c.surface, Direction(cosTheta, 1.0f), i).weight.x;
            const double bound = c.surface.kind == kWalkRefracts ? 1e-3 : 1e-4;
            EXPECT_NEAR(sum / kWalks, 1.0, bound) << c.name << " cos " << cosTheta;
        }
    }
}

// Light by the sampled walks, and by the estimate of f at random directions, cell by cell.
TEST(MultiscatterWalk, EstimateIsTheDensityOfWeightedWalks) {
    constexpr int kZCount = 8;
    constexpr int kPhiCount = 6;
    constexpr uint kCount = 60'000;
    const auto cellOf = [](vec3 w) {
        const double turn = std::atan2(w.y, w.x) / (2.0 * M_PI);
        const int z = std::min(static_cast<int>((w.z + 1.0) * 0.5 * kZCount), kZCount - 1);
        const int phi =
            std::min(static_cast<int>((turn < 0.0 ? turn + 1.0 : turn) * kPhiCount), kPhiCount - 1);
        return static_cast<size_t>(z * kPhiCount + phi);
    };
    struct Moments {
        double sum = 0.0;
        double squares = 0.0;
        void Add(double x) { sum += x, squares += x * x; }
        double Mean() const { return sum / kCount; }
        double Variance() const { return (squares / kCount - Mean() * Mean()) / kCount; }
    };
    for (const vec2 alpha : {vec2(0.5f, 0.5f), vec2(1.0f, 1.0f), vec2(0.8f, 0.25f)}) {
        for (const Case& c : Cases(alpha)) {
            const vec3 wo = Direction(0.4f, 0.7f);
            std::vector<Moments> sampled(kZCount * kPhiCount);
            std::vector<Moments> estimated(kZCount * kPhiCount);
            for (uint i = 0; i < kCount; ++i) {
                const WalkSample s = SampleWalk(c.surface, wo, i);
                if (s.weight.x > 0.0f) sampled[cellOf(s.wi)].Add(s.weight.x);
                WalkRng rng = StartWalkRng(i ^ 0x80000000u);
                const vec3 wi = SampleUniformSphere(WalkGet2D(rng));
                const vec3 value = EstimateWalk(c.surface, wo, wi, rng.state);
                estimated[cellOf(wi)].Add(static_cast<double>(value.x) * 4.0 * M_PI);
            }
            double worst = 0.0;
            for (size_t i = 0; i < sampled.size(); ++i) {
                const double variance = sampled[i].Variance() + estimated[i].Variance();
                const double difference = std::abs(sampled[i].Mean() - estimated[i].Mean());
                if (difference > 1e-4) worst = std::max(worst, difference / std::sqrt(variance));
            }
            // 5 sigma: 18 cases of 48 cells
            EXPECT_LT(worst, 5.0) << c.name << " alpha " << alpha.x << "," << alpha.y;
        }
    }
}

// Means of the estimate from both ends; radiance through the surface scales by the square of the index.
TEST(MultiscatterWalk, EstimateIsReciprocalOnAverage) {
    constexpr uint kCount = 60'000;
    std::mt19937 generator(11);
    for (const vec2 alpha : kAlphas) {
        for (const Case& c : Cases(alpha)) {
            const auto cosine = [&] { return 0.1f + 0.9f * static_cast<float>(generator() >> 8) * 0x1p-24f; };
            const vec3 wo = Direction(cosine(), 0.3f);
            const bool isThrough = c.surface.kind == kWalkRefracts;
            // Nearly straight through, where the light is
            vec3 wi = Direction(cosine(), 2.9f);
            WalkSurface back = c.surface;
            vec3 backWo = wi;
            vec3 backWi = wo;
            if (isThrough) {
                wi = normalize(vec3(-wo.x / c.surface.eta, -wo.y / c.surface.eta, -0.8f));
                backWo = -wi;
                backWi = -wo;
                back.eta = 1.0f / c.surface.eta;
            }
            double there = 0.0;
            double thereSquares = 0.0;
            double again = 0.0;
            double againSquares = 0.0;
            for (uint i = 0; i < kCount; ++i) {
                const double a = EstimateWalk(c.surface, wo, wi, i).x / std::abs(wi.z);
                // f of radiance is this over the square of each index; both sides times the first's
                const double b = EstimateWalk(back, backWo, backWi, i + kCount).x / std::abs(backWi.z) *
                                 (isThrough ? static_cast<double>(Sqr(c.surface.eta)) : 1.0);
                there += a;
                thereSquares += a * a;
                again += b;
                againSquares += b * b;
            }
            there /= kCount;
            again /= kCount;
            const double sigma = std::sqrt(
                (thereSquares / kCount - there * there + againSquares / kCount - again * again + 1e-20) /
                kCount);
            EXPECT_NEAR(there, again, 5.0 * sigma + 1e-3 * there)
                << c.name << " alpha " << alpha.x << "," << alpha.y;
        }
    }
}

TEST(MultiscatterWalk, SmoothFacetsScatterOnce) {
    const WalkSurface surface = Surface(kWalkAbsorbs, vec2(0.001f, 0.001f), 1.5f, 1.0f);
    for (uint i = 0; i < 10'000; ++i) {
        const WalkSample s = SampleWalk(surface, Direction(0.7f, 1.0f), i);
        ASSERT_EQ(s.bounceCount, 1u);
        ASSERT_NEAR(s.wi.z, 0.7f, 0.1f);
    }
}

TEST(MultiscatterWalk, ColorDeepensWithEachBounce) {
    const WalkSurface surface = Surface(kWalkAbsorbs, vec2(1.0f, 1.0f), 1.5f, 0.5f);
    WalkSurface flat = surface;
    flat.fresnel.f90 = vec3(0.5f);
    for (uint i = 0; i < 10'000; ++i) {
        const WalkSample s = SampleWalk(flat, Direction(0.7f, 1.0f), i);
        ASSERT_NEAR(s.weight.x, std::exp2(-static_cast<float>(s.bounceCount)), 1e-6f);
    }
}

TEST(MultiscatterWalk, IsAFunctionOfItsSeed) {
    const WalkSurface surface = Surface(kWalkRefracts, vec2(1.0f, 1.0f), 1.5f, 0.04f);
    const vec3 wo = Direction(0.4f, 1.0f);
    EXPECT_EQ(SampleWalk(surface, wo, 5u).wi, SampleWalk(surface, wo, 5u).wi);
    EXPECT_NE(SampleWalk(surface, wo, 5u).wi, SampleWalk(surface, wo, 6u).wi);
    const vec3 wi = Direction(0.9f, 1.0f);
    EXPECT_EQ(EstimateWalk(surface, wo, wi, 5u), EstimateWalk(surface, wo, wi, 5u));
}

}  // namespace
}  // namespace raygraph::shading::multiscatter_walk_test
