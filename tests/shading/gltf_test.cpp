// Materials of glTF as a whole: their samples, their energy, their boundaries, and what features leave out.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <random>

#include "core/frame.glsl"
#include "shared/energy_tables.h"
#include "shared/scene_records.h"
#include "tests/shading/gltf_lobe.h"
#include "tests/support/chi_square.h"

namespace raygraph::shading::gltf_test {
namespace {

struct View {
    std::string name;
    GltfBxDF lobe;
    vec3 wo;
};

// Each kind of material, rough and less so, from above to grazing.
std::vector<View> Views() {
    std::vector<View> views;
    const auto add = [&](const char* name, const GltfBxDF& lobe, std::initializer_list<float> cosines) {
        for (const float c : cosines)
            views.push_back(
                {std::string(name) + " alpha " + std::to_string(lobe.alpha.x) + " cos " + std::to_string(c),
                 lobe, DirectionAt(c, 0.8f)});
    };
    GltfBxDF brushed = Metal(0.6f, vec3(1.0f, 0.7f, 0.3f));
    brushed.alpha.y = 0.15f;
    add("metal", Metal(0.3f, vec3(1.0f, 0.7f, 0.3f)), {0.8f, 0.05f});
    GltfBxDF grooves = Glass(0.02f, 1.0f / 1.5f);
    grooves.alpha.x = 0.5f;
    add("brushed metal", brushed, {0.5f});
    add("brushed glass from inside", grooves, {0.6f});
    add("dielectric", GltfLobe(0.3f), {0.9f, 0.1f});
    add("glass from outside", Glass(0.3f, 1.5f), {0.9f, 0.1f});
    add("glass from inside", Glass(0.3f, 1.0f / 1.5f), {0.9f, 0.3f});
    add("thin wall", ThinGlass(0.3f), {0.6f});
    add("blend", Blend(0.3f), {0.6f});
    add("metal", Metal(1.0f), {0.7f});
    add("glass from inside", Glass(1.0f, 1.0f / 1.5f), {0.7f});
    add("blend", Blend(1.0f), {0.2f});
    if (!AreTestsLong()) return views;
    for (const float alpha : {0.1f, 0.2f, 0.5f, 0.8f}) {
        GltfBxDF thinBlend = Blend(alpha);
        thinBlend.isThin = true;
        add("metal", Metal(alpha), {1.0f, 0.4f, 0.02f});
        add("dielectric", GltfLobe(alpha), {1.0f, 0.4f, 0.02f});
        add("glass", Glass(alpha, 1.1f), {1.0f, 0.4f});
        add("glass", Glass(alpha, 2.4f), {1.0f, 0.4f, 0.05f});
        add("glass from inside", Glass(alpha, 1.0f / 2.4f), {1.0f, 0.4f, 0.05f});
        add("thin blend", thinBlend, {1.0f, 0.4f, 0.05f});
        add("blend", Blend(alpha), {1.0f, 0.4f, 0.05f});
    }
    return views;
}

template <typename Visit>
void ForEachSample(const View& view, uint count, Visit&& visit) {
    GltfBxDF lobe = view.lobe;
    for (uint i = 0; i < count; ++i) {
        Sampler rng = StartPixelSample(uvec2(5u, 2u), i, 9u);
        lobe.seed = MixBits(i);
        const float uc = Get1D(rng);
        const GltfBSDF prepared = Prepare(lobe, view.wo);
        visit(prepared, Sample_f(prepared, uc, Get2D(rng)));
    }
}

// A grid about where a smooth surface would send the light.
PolarGrid GridAbout(const View& view, bool isAbove) {
    const vec3 up(0.0f, 0.0f, 1.0f);
    PolarGrid grid;
    grid.squarings = 1;
    grid.axis = isAbove ? Reflect(view.wo, up) : -view.wo;
    if (!isAbove && !view.lobe.isThin && !Refract(view.wo, up, view.lobe.eta, grid.axis)) grid.axis = -up;
    return grid;
}

// Facets send some samples to the wrong side of the surface. They form one more cell, which expects what the
// density leaves below 1: so that it integrates to one with them is tested, too.
TEST(Gltf, SampledDirectionsFollowPDF) {
    const std::vector<View> views = Views();
    const double level = test::SidakLevel(0.01, static_cast<int>(views.size()));
    uint32_t seed = 500;
    for (const View& view : views) {
        const std::vector<LobePart> parts = {{GridAbout(view, true), [](vec3 wi) { return wi.z > 0.0f; }},
                                             {GridAbout(view, false), [](vec3 wi) { return wi.z < 0.0f; }}};
        const test::ChiSquareResult result =
            ChiSquareOfLobe(SeenFrom(view.lobe, view.wo), view.wo, parts, seed++);
        EXPECT_GT(result.degreesOfFreedom, 50) << view.name;
        EXPECT_GT(result.pValue, level)
            << view.name << ", chi-squared " << result.statistic << " of " << result.degreesOfFreedom;
    }
}

TEST(Gltf, SampleAgreesWithFAndPDF) {
    for (const View& view : Views()) {
        ForEachSample(view, 4000u, [&](const GltfBSDF& prepared, const BSDFSample& s) {
            if (s.pdf == 0.0f) return;
            GltfBxDF lobe = view.lobe;
            lobe.seed = prepared.seed;
            ASSERT_EQ(s.f, f(lobe, view.wo, s.wi)) << view.name;
            ASSERT_EQ(s.pdf, PDF(lobe, view.wo, s.wi)) << view.name;
            ASSERT_EQ(s.f, f(prepared, s.wi)) << view.name;
            ASSERT_GE(min(s.f.x, min(s.f.y, s.f.z)), 0.0f) << view.name;
            ASSERT_NEAR(length(s.wi), 1.0f, 1e-5f) << view.name;
            ASSERT_EQ(IsTransmissive(s.flags), s.wi.z < 0.0f) << view.name;
            const bool isRefracted = s.wi.z < 0.0f && !view.lobe.isThin;
            ASSERT_EQ(s.eta, isRefracted ? view.lobe.eta : 1.0f) << view.name;
        });
    }
}

vec3 RandomDirection(std::mt19937& generator, bool isAbove) {
    const auto unit = [&] { return static_cast<float>(generator() >> 8) * 0x1p-24f; };
    const float z = 0.02f + 0.98f * unit();
    return DirectionAt(isAbove ? z : -z, 6.2831f * unit());
}

// The largest ratio of f one way to f the other way, in any channel.
double WorstRatio(GltfBxDF lobe) {
    std::mt19937 generator(17);
    double worst = 1.0;
    const auto note = [&](vec3 a, vec3 b) {
        for (int c = 0; c < 3; ++c) {
            // Values in the tail of the floats say nothing
            if (std::max(a[c], b[c]) < 1e-5f) continue;
            const double ratio = static_cast<double>(a[c]) / static_cast<double>(b[c]);
            worst = std::max(worst, std::max(ratio, 1.0 / ratio));
        }
    };
    for (int i = 0; i < 20'000; ++i) {
        const vec3 a = RandomDirection(generator, true);
        vec3 b = RandomDirection(generator, true);
        note(f(lobe, a, b), f(lobe, b, a));
        if (lobe.transmission == 0.0f) continue;
        b = RandomDirection(generator, false);
        if (lobe.isThin) {
            note(f(lobe, a, b), f(lobe, -b, -a));
            continue;
        }
        // From the other side the frame is mirrored; radiance scales by the square of the index
        GltfBxDF behind = lobe;
        behind.eta = 1.0f / lobe.eta;
        note(f(lobe, a, b) * Sqr(lobe.eta), f(behind, -b, -a));
    }
    return worst;
}

TEST(Gltf, SingleScatteringIsReciprocal) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    for (const float alpha : {0.2f, 0.5f, 1.0f}) {
        EXPECT_LT(WorstRatio(Metal(alpha, vec3(1.0f, 0.5f, 0.1f))), 1.001);
        EXPECT_LT(WorstRatio(GltfLobe(alpha)), 1.001);
        EXPECT_LT(WorstRatio(Glass(alpha, 1.5f)), 1.1);  // rounding of half vectors at grazing angles
        EXPECT_LT(WorstRatio(ThinGlass(alpha)), 1.001);
    }
}

// The bounds that the documentation states.
TEST(Gltf, CompensatedLobesAreReciprocalWithinTheirBound) {
    const MultiscatterScope scope(MultiscatterKind::Lut);
    struct Bound {
        float alpha, metal, dielectric, thin;
    };
    for (const Bound bound :
         {Bound{0.2f, 1.4f, 1.1f, 1.4f}, {0.5f, 1.8f, 1.1f, 1.8f}, {1.0f, 3.3f, 1.1f, 3.3f}}) {
        EXPECT_LT(WorstRatio(Metal(bound.alpha)), bound.metal) << bound.alpha;
        EXPECT_LT(WorstRatio(GltfLobe(bound.alpha)), bound.dielectric) << bound.alpha;
        EXPECT_LT(WorstRatio(ThinGlass(bound.alpha)), bound.thin) << bound.alpha;
        // It is not reciprocal: the bounds above are of something
        EXPECT_GT(WorstRatio(Metal(bound.alpha)), 1.1f) << bound.alpha;
    }
}

TEST(Gltf, SmoothSurfacesAreDeltas) {
    for (const float eta : {1.5f, 1.0f / 1.5f}) {
        const View view{"smooth glass", Glass(0.0f, eta), DirectionAt(0.9f, 1.0f)};
        double transmitted = 0.0;
        constexpr uint kCount = 1u << 14;
        ForEachSample(view, kCount, [&](const GltfBSDF& prepared, const BSDFSample& s) {
            ASSERT_GT(s.pdf, 0.0f);
            ASSERT_TRUE(IsSpecular(s.flags));
            ASSERT_EQ(f(prepared, s.wi), vec3(0.0f));
            ASSERT_EQ(PDF(prepared, s.wi), 0.0f);
            const float weight = s.f.y * std::abs(s.wi.z) / s.pdf;
            if (s.wi.z > 0.0f) {
                ASSERT_NEAR(s.wi.x, -view.wo.x, 1e-6f);
                ASSERT_NEAR(weight, 1.0f, 1e-5f);
            } else {
                ASSERT_NEAR(eta * s.wi.x, -view.wo.x, 1e-6f);  // Snell
                ASSERT_NEAR(weight * eta * eta, 1.0f, 1e-5f);
                transmitted += 1.0;
            }
        });
        const float cosine = eta > 1.0f ? 0.9f : RefractedCosine(0.9f, eta);
        EXPECT_NEAR(transmitted / kCount, 0.96f * (1.0f - SchlickWeight(cosine)), 1e-3);
    }
    // Beyond the critical angle
    const Albedo inside = MeasureAlbedo(Glass(0.0f, 1.0f / 1.5f), DirectionAt(0.5f, 0.0f), 1u << 10);
    EXPECT_NEAR(inside.reflected.x, 1.0, 1e-6);
    // Smooth over diffuse: the base is still there for lights
    EXPECT_GT(f(GltfLobe(0.0f), DirectionAt(0.8f, 0.0f), DirectionAt(0.3f, 0.0f)).x, 0.2f);
    EXPECT_TRUE(IsNonSpecular(Flags(GltfLobe(0.0f))));
    EXPECT_TRUE(IsSpecular(Flags(GltfLobe(0.0f))));
}

TEST(Gltf, StraightShareIsWhatASmoothThinWallPasses) {
    std::mt19937 random(5u);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    for (int i = 0; i < 200; ++i) {
        GltfBxDF lobe = Blend(0.0f);
        lobe.isThin = true;
        lobe.metallic = 0.8f * unit(random);
        lobe.transmission = 0.1f + 0.9f * unit(random);
        lobe.specular = unit(random);
        lobe.eta = 0.6f + 1.5f * unit(random);
        const vec3 wo = DirectionAt(0.02f + 0.98f * unit(random), 0.8f);
        const GltfBSDF wall = Prepare(lobe, wo);
        const float chance = PassThroughProbability(wall);
        const BSDFSample through = Sample_f(wall, 0.9999999f, vec2(0.5f));
        ASSERT_TRUE(IsTransmissive(through.flags));
        EXPECT_NEAR(through.pdf, chance, 1e-6f);
        EXPECT_LT(length(through.wi + wo), 1e-6f);
        const vec3 share = PassThroughWeight(lobe, lobe, wo);
        EXPECT_EQ(PassThroughWeight(wall), share);
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(through.f[channel] * wo.z, share[channel], 2e-6f);
        // The rest of the wall: the same lobes, chosen as before among the samples that do not go straight
        const GltfBSDF rest = WithoutPassThrough(wall, chance);
        for (const float uc : {0.01f, 0.3f, 0.7f, 0.99f}) {
            const BSDFSample before = Sample_f(wall, uc * (1.0f - chance), vec2(0.3f, 0.6f));
            const BSDFSample after = Sample_f(rest, uc, vec2(0.3f, 0.6f));
            EXPECT_EQ(before.flags, after.flags);
            EXPECT_LT(length(before.wi - after.wi), 1e-6f);
            EXPECT_NEAR(before.pdf, after.pdf * (1.0f - chance), 1e-5f * before.pdf);
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_NEAR(before.f[channel], after.f[channel], 1e-5f * before.f[channel]);
        }
    }
}

TEST(Gltf, SpecularAndColorSetTheLayer) {
    const vec3 up = DirectionAt(1.0f, 0.0f);
    GltfBxDF lobe = GltfLobe(0.0f);
    lobe.baseColor = vec3(0.0f);
    lobe.specularColor = vec3(0.5f, 1.0f, 100.0f);
    lobe.specular = 0.5f;
    const Albedo albedo = MeasureAlbedo(lobe, up, 1u << 10);
    EXPECT_NEAR(albedo.reflected.x, 0.01, 1e-4);
    EXPECT_NEAR(albedo.reflected.y, 0.02, 1e-4);
    EXPECT_NEAR(albedo.reflected.z, 0.5, 1e-4);
    lobe.specular = 0.0f;
    lobe.baseColor = vec3(0.3f);
    // Only the Lambert lobe remains
    EXPECT_NEAR(f(lobe, DirectionAt(0.4f, 0.0f), DirectionAt(0.2f, 2.0f)).x, 0.3f / 3.14159265f, 1e-3f);
}

// The light of a soft lamp, by samples of the BSDF, by directions towards everywhere, and by both with their
// densities as weights: walks are estimated without bias by each, though PDF is not their density.
TEST(Gltf, WalksAreUnbiasedUnderMultipleImportanceSampling) {
    const MultiscatterScope scope(MultiscatterKind::Walk);
    const auto lamp = [](vec3 w) { return Sqr(Sqr(0.5f + 0.5f * dot(w, DirectionAt(-0.1f, 2.0f)))); };
    for (const View& view : Views()) {
        constexpr uint kCount = 40'000;
        double sums[3] = {};
        double squares[3] = {};
        const auto add = [&](int which, double x) {
            sums[which] += x;
            squares[which] += x * x;
        };
        Uniform uniform(40);
        GltfBxDF lobe = view.lobe;
        for (uint i = 0; i < kCount; ++i) {
            lobe.seed = MixBits(i + 1u);
            const GltfBSDF prepared = Prepare(lobe, view.wo);
            const float uc = uniform();
            const BSDFSample s = Sample_f(prepared, uc, uniform.Pair());
            double both = 0.0;
            double alone = 0.0;
            if (s.pdf > 0.0f) {
                alone = static_cast<double>(s.f.y * std::abs(s.wi.z) / s.pdf * lamp(s.wi));
                both = alone * static_cast<double>(s.pdf / (s.pdf + UniformSpherePDF()));
            }
            add(0, alone);
            const vec3 wi = SampleUniformSphere(uniform.Pair());
            float pdf = 0.0f;
            const vec3 value = Evaluate(prepared, wi, pdf);
            const double direct =
                static_cast<double>(value.y * std::abs(wi.z) * lamp(wi) / UniformSpherePDF());
            add(1, direct);
            add(2, both + direct * static_cast<double>(UniformSpherePDF() / (pdf + UniformSpherePDF())));
        }
        const auto variance = [&](int i) {
            const double mean = sums[i] / kCount;
            return (squares[i] / kCount - mean * mean) / kCount;
        };
        for (const int other : {1, 2}) {
            EXPECT_NEAR(sums[0] / kCount, sums[other] / kCount,
                        4.5 * std::sqrt(variance(0) + variance(other)))
                << view.name << " strategy " << other;
        }
    }
}

// Each lobe alone, smooth and rough, and all of them together.
TEST(Gltf, ViewerBelowOrEdgeOnSeesNothing) {
    for (const float alpha : {0.0f, 0.3f}) {
        GltfBxDF base = GltfLobe(alpha);
        base.specular = 0.0f;
        GltfBxDF layer = GltfLobe(alpha);
        layer.baseColor = vec3(0.0f);
        for (const GltfBxDF& lobe : {Metal(alpha), layer, base, Glass(alpha, 1.5f), Glass(alpha, 1.0f / 1.5f),
                                     ThinGlass(alpha), Blend(alpha)}) {
            for (const float z : {0.0f, -0.5f}) {
                const vec3 wo = DirectionAt(z, 0.0f);
                for (const float uc : {0.0f, 0.5f, 0.99999994f})
                    EXPECT_EQ(Sample_f(lobe, wo, uc, vec2(0.3f, 0.6f)).pdf, 0.0f) << alpha << " " << z;
                for (const float other : {0.5f, -0.5f}) {
                    EXPECT_EQ(f(lobe, wo, DirectionAt(other, 0.0f)), vec3(0.0f)) << alpha << " " << z;
                    EXPECT_EQ(PDF(lobe, wo, DirectionAt(other, 0.0f)), 0.0f) << alpha << " " << z;
                }
            }
        }
    }
    GltfBxDF black = Metal(0.3f, vec3(0.0f));
    black.metallic = 0.0f;
    black.specular = 0.0f;
    EXPECT_EQ(Sample_f(black, DirectionAt(0.5f, 0.0f), 0.5f, vec2(0.3f, 0.6f)).pdf, 0.0f);
}

TEST(Gltf, NothingIsInfiniteAtTheEnds) {
    std::mt19937 generator(3);
    const auto pick = [&](std::initializer_list<float> values) {
        return values.begin()[generator() % values.size()];
    };
    for (const MultiscatterKind kind :
         {MultiscatterKind::Off, MultiscatterKind::Lut, MultiscatterKind::Walk}) {
        const MultiscatterScope scope(kind);
        for (int i = 0; i < 20'000; ++i) {
            GltfBxDF lobe = GltfLobe(pick({0.0f, 0.001f, 0.0011f, 0.02f, 1.0f}));
            lobe.baseColor = vec3(pick({0.0f, 1.0f}), 0.5f, pick({0.0f, 1.0f}));
            lobe.metallic = pick({0.0f, 0.5f, 1.0f});
            lobe.transmission = pick({0.0f, 0.5f, 1.0f});
            lobe.specular = pick({0.0f, 1.0f});
            lobe.specularColor = vec3(pick({0.0f, 1.0f, 1e4f}));
            lobe.eta = pick({0.1f, 0.999f, 1.0f, 1.0001f, 1.5f, 10.0f, 1e6f});
            lobe.isThin = generator() % 2 != 0;
            lobe.seed = static_cast<uint>(generator());
            const vec3 wo = DirectionAt(pick({1.0f, 0.9999999f, 0.5f, 1e-3f, 1e-6f, 1e-20f}), 1.0f);
            const vec2 u(pick({0.0f, 0.5f, 0.99999994f}), pick({0.0f, 0.3f, 0.99999994f}));
            const GltfBSDF prepared = Prepare(lobe, wo);
            const BSDFSample s = Sample_f(prepared, pick({0.0f, 0.4f, 0.99999994f}), u);
            const auto isGood = [](float x) { return std::isfinite(x) && x >= 0.0f; };
            ASSERT_TRUE(isGood(s.pdf)) << i;
            if (s.pdf == 0.0f) continue;
            float pdf = 0.0f;
            const vec3 value = Evaluate(prepared, s.wi, pdf);
            for (int c = 0; c < 3; ++c) {
                ASSERT_TRUE(isGood(s.f[c]))
                    << i << " " << s.f[c] << " kind " << int(kind) << " alpha " << lobe.alpha.x
                    << " metallic " << lobe.metallic << " transmission " << lobe.transmission << " specular "
                    << lobe.specular << " tint " << lobe.specularColor.x << " eta " << lobe.eta << " thin "
                    << lobe.isThin << " cos " << wo.z << " to " << s.wi.z << " base " << lobe.baseColor[c]
                    << " pdf " << s.pdf;
                ASSERT_TRUE(isGood(value[c])) << i;
            }
            ASSERT_TRUE(isGood(pdf)) << i;
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::gltf_test

namespace raygraph::shading::energy_test {
namespace {

const std::vector<float> kAlphas = {0.002f, 0.1f, 0.23f, 0.45f, 1.0f};
const std::vector<float> kCosines = {1.0f, 0.41f, 0.17f, 0.06f};

template <typename Check>
void ForEachAlphaAndCosine(Check&& check) {
    for (const float alpha : kAlphas) {
        for (const float cosTheta : kCosines) {
            SCOPED_TRACE("alpha " + std::to_string(alpha) + " cos " + std::to_string(cosTheta));
            check(alpha, DirectionAt(cosTheta, 0.6f));
        }
    }
}

uint SampleCount() {
    return AreTestsLong() ? 1u << 18 : 1u << 13;
}

struct NamedLobe {
    const char* name;
    GltfBxDF lobe;
};

// Lobes that take nothing away.
std::vector<NamedLobe> WhiteLobes(float alpha) {
    GltfBxDF half = GltfLobe(alpha);
    half.metallic = 0.5f;
    half.transmission = 0.5f;
    GltfBxDF dull = Glass(alpha, 1.5f);
    dull.specular = 0.0f;
    GltfBxDF tinted = Glass(alpha, 1.5f);
    tinted.specularColor = vec3(8.0f);
    return {{"metal", Metal(alpha)},
            {"glass from outside", Glass(alpha, 1.5f)},
            {"glass from inside", Glass(alpha, 1.0f / 1.5f)},
            {"diamond from outside", Glass(alpha, 2.42f)},
            {"diamond from inside", Glass(alpha, 1.0f / 2.42f)},
            {"nearly matched media", Glass(alpha, 1.02f)},
            {"nearly matched media, from inside", Glass(alpha, 1.0f / 1.02f)},
            {"glass without reflections", dull},
            {"glass of strong reflections", tinted},
            {"thin wall", ThinGlass(alpha)},
            {"dielectric over diffuse", GltfLobe(alpha)},
            {"half of each", half}};
}

TEST(EnergyTables, HaveTheirSizeAndReturnNoMoreThanThereIs) {
    ASSERT_EQ(EnergyTables().size(), kEnergyEntryCount);
    for (uint i = 0; i < kEnergyCosCount * kEnergyAlphaCount; ++i) {
        const EnergyEntry entry = EnergyEntryOf(kEnergyReflectionOffset + i);
        ASSERT_LE(entry.first.x + entry.first.y, 1.0001f) << i;
        ASSERT_LE(entry.first.w, entry.first.z + 1e-4f) << i;  // s1 s2 is at most the mean of the two
        ASSERT_LE(entry.first.x + entry.first.y + entry.first.z, 1.0001f) << i;
    }
}

TEST(EnergyTables, OneBounceIsWhatThatManyWalksLeaveAfter) {
    WalkSurface surface{};
    surface.kind = kWalkAbsorbs;
    surface.eta = 1.5f;
    surface.fresnel.f0 = vec3(0.0f, 0.04f, 1.0f);
    surface.fresnel.f90 = vec3(1.0f);
    surface.fresnel.isMetal = false;
    constexpr uint kWalks = 40'000;
    ForEachAlphaAndCosine([&](float alpha, vec3 wo) {
        surface.alpha = vec2(alpha);
        glm::dvec3 sum(0.0);
        for (uint i = 0; i < kWalks; ++i) {
            const WalkSample s = SampleWalk(surface, wo, i);
            if (s.bounceCount == 1u) sum += glm::dvec3(s.weight);
        }
        const FacetEnergy energy = FacetEnergyAt(EnergyRow(alpha), wo.z);
        const vec3 expected = SingleAlbedo(energy, surface.fresnel.f0, surface.fresnel.f90);
        // 4 sigma of the walks, and the interpolation
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / kWalks, expected[c], 0.01 + 0.004) << c;
    });
}

TEST(Energy, WalkReturnsAllLight) {
    const MultiscatterScope scope(MultiscatterKind::Walk);
    ForEachAlphaAndCosine([](float alpha, vec3 wo) {
        for (const NamedLobe& white : WhiteLobes(alpha)) {
            // The diffuse base takes the layer's albedo from the tables
            const double bound = white.lobe.metallic < 1.0f && white.lobe.transmission < 1.0f ? 0.015 : 0.005;
            EXPECT_NEAR(MeasureAlbedo(white.lobe, wo, SampleCount()).Sum().y, 1.0, bound) << white.name;
        }
    });
}

TEST(Energy, TablesReturnAllLight) {
    const MultiscatterScope scope(MultiscatterKind::Lut);
    ForEachAlphaAndCosine([](float alpha, vec3 wo) {
        for (const NamedLobe& white : WhiteLobes(alpha)) {
            // The tables are coarse where the refraction all but ends
            const double bound = std::abs(white.lobe.eta - 1.0f) < 0.03f ? 0.025 : 0.015;
            EXPECT_NEAR(MeasureAlbedo(white.lobe, wo, SampleCount()).Sum().y, 1.0, bound) << white.name;
        }
    });
}

TEST(Energy, WithoutEitherRoughSurfacesAreDark) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    // Reference: 1 - ln 2 for alpha = 1 from above
    EXPECT_NEAR(MeasureAlbedo(Metal(1.0f), DirectionAt(1.0f, 0.0f), 1u << 16).Sum().x, 1.0 - std::log(2.0),
                1e-3);
    // The layer over a diffuse base loses nothing even so: what it does not reflect goes down
    EXPECT_NEAR(MeasureAlbedo(GltfLobe(1.0f), DirectionAt(0.7f, 0.0f), 1u << 16).Sum().x, 1.0, 0.005);
}

TEST(Energy, TablesAndWalkHaveTheSameAlbedo) {
    const auto compare = [](const char* name, const GltfBxDF& lobe, vec3 wo, double bound) {
        Albedo walk;
        Albedo lut;
        {
            const MultiscatterScope scope(MultiscatterKind::Walk);
            walk = MeasureAlbedo(lobe, wo, 2u * SampleCount());
        }
        {
            const MultiscatterScope scope(MultiscatterKind::Lut);
            lut = MeasureAlbedo(lobe, wo, 2u * SampleCount());
        }
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(lut.reflected[c], walk.reflected[c], bound) << name << ", reflected " << c;
            EXPECT_NEAR(lut.transmitted[c], walk.transmitted[c], bound) << name << ", transmitted " << c;
        }
    };
    ForEachAlphaAndCosine([&](float alpha, vec3 wo) {
        compare("metal", Metal(alpha, vec3(0.2f, 0.5f, 0.9f)), wo, 0.015);
        GltfBxDF layer = GltfLobe(alpha);
        layer.baseColor = vec3(0.0f);
        layer.specularColor = vec3(1.0f, 4.0f, 16.0f);
        compare("layer", layer, wo, 0.015);
        compare("glass from outside", Glass(alpha, 1.5f), wo, 0.015);
        compare("glass from inside", Glass(alpha, 1.0f / 1.5f), wo, 0.015);
    });
}

// Whatever the parameters, no material reflects more than it receives.
TEST(Energy, FurnaceIsNeverAboveOne) {
    Sampler rng = StartPixelSample(uvec2(0u, 0u), 0u, 1u);
    const MultiscatterScope scope(MultiscatterKind::Lut);
    const int materialCount = AreTestsLong() ? 2000 : 300;
    for (int i = 0; i < materialCount; ++i) {
        GltfBxDF lobe = GltfLobe(Sqr(Get1D(rng)));
        const auto extreme = [&] { return clamp(2.0f * Get1D(rng) - 0.5f, 0.0f, 1.0f); };
        lobe.alpha.y *= i % 4 == 0 ? 0.3f + 0.7f * Get1D(rng) : 1.0f;
        lobe.baseColor = vec3(extreme(), 1.0f, extreme());
        lobe.metallic = extreme();
        lobe.transmission = extreme();
        lobe.specular = extreme();
        lobe.specularColor = 3.0f * vec3(Get1D(rng), Get1D(rng), extreme());
        lobe.eta = exp2(3.0f * Get1D(rng) - 1.5f);
        lobe.isThin = i % 3 == 0;
        const vec3 wo = DirectionAt(0.02f + 0.98f * Get1D(rng), 6.28f * Get1D(rng));
        // Factors of anisotropic surfaces are estimates
        double bound = i % 4 == 0 ? 1.03 : 1.015;
        // The tables of glass are coarse at grazing angles
        if (lobe.transmission > 0.0f && wo.z < 0.05f) bound = std::max(bound, 1.03);
        const glm::dvec3 albedo = MeasureAlbedo(lobe, wo, AreTestsLong() ? 1u << 15 : 1u << 12).Sum();
        for (int c = 0; c < 3; ++c) {
            ASSERT_LE(albedo[c], bound)
                << "material " << i << " alpha " << lobe.alpha.x << "," << lobe.alpha.y << " metallic "
                << lobe.metallic << " transmission " << lobe.transmission << " eta " << lobe.eta << " cos "
                << wo.z << " specular " << lobe.specular << " thin " << lobe.isThin << " tint "
                << lobe.specularColor[c];
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::energy_test

// Boundaries between media, and how much light a colored layer passes to the lobes below it.
namespace raygraph::shading::boundary_test {
namespace {

// The mean over the hemisphere, weighted by the cosine, of what a facet of the lobe reflects.
template <typename Reflectance>
double HemisphericalMean(Reflectance&& reflectance) {
    constexpr int kPoints = 20'000;
    double sum = 0.0;
    for (int i = 0; i < kPoints; ++i) {
        const double u = (i + 0.5) / kPoints;
        const double c = u * u;  // dense towards grazing
        sum += 2.0 * c * 2.0 * u * static_cast<double>(reflectance(static_cast<float>(c)));
    }
    return sum / kPoints;
}

double SchlickMean(float eta) {
    const FacetFresnel fresnel = DielectricFresnel(Glass(0.0f, eta));
    return HemisphericalMean([&](float c) { return FacetReflectance(fresnel, c, eta).y; });
}

double ExactMean(float eta) {
    return HemisphericalMean([&](float c) { return FresnelDielectric(c, eta); });
}

TEST(Boundary, EqualIndicesReflectNothingAtAnyAngle) {
    const FacetFresnel fresnel = DielectricFresnel(Glass(0.0f, 1.0f));
    for (float c = 0.01f; c <= 1.0f; c += 0.01f) {
        EXPECT_EQ(FacetReflectance(fresnel, c, 1.0f).y, 0.0f) << c;
        EXPECT_EQ(OutsideReflectance(fresnel, c, 1.0f).y, 0.0f) << c;
    }
    for (const float cosTheta : {1.0f, 0.17f, 0.05f}) {
        const vec3 wo = DirectionAt(cosTheta, 0.3f);
        const Albedo smooth = MeasureAlbedo(Glass(0.0f, 1.0f), wo, 1u << 8);
        EXPECT_EQ(smooth.reflected.y, 0.0) << cosTheta;
        EXPECT_NEAR(smooth.transmitted.y, 1.0, 1e-6) << cosTheta;
        // A varnish of the index of the water that it lies in is not there
        const vec3 base = f(GltfLobe(0.3f), wo, DirectionAt(0.4f, 2.0f));
        GltfBxDF varnish = GltfLobe(0.3f);
        varnish.eta = 1.0f;
        const vec3 bare = f(varnish, wo, DirectionAt(0.4f, 2.0f));
        EXPECT_NEAR(bare.y, kInvPi, 1e-6f) << cosTheta;
        EXPECT_NE(bare.y, base.y) << cosTheta;
    }
}

TEST(Boundary, MeanReflectanceIsFresnelsFromBothSides) {
    EXPECT_NEAR(ExactMean(1.5f / 1.33f), 0.0308, 1e-4);
    EXPECT_NEAR(ExactMean(1.5f), 0.0918, 1e-4);
    for (const float eta :
         {1.002f, 1.33f / 1.31f, 1.05f, 1.1f, 1.5f / 1.33f, 1.2f, 1.27f, 1.31f, 1.33f, 1.4f}) {
        const double exact = ExactMean(eta);
        EXPECT_NEAR(SchlickMean(eta), exact, 0.05 * exact) << eta;
        const double inside = ExactMean(1.0f / eta);
        EXPECT_NEAR(SchlickMean(1.0f / eta), inside, 0.05 * inside) << "from the denser side, " << eta;
    }
    // The error that the formula states, without total reflection and the bound of 1
    for (float eta = 1.005f; eta < 1.34f; eta *= 1.01f)
        EXPECT_NEAR(SchlickMean(eta) / ExactMean(eta), 1.0, 0.006) << eta;
}

TEST(Boundary, IndicesOfCommonGlassInAirKeepTheF90OfGltf) {
    for (const float eta : {1.35f, 1.5f, 1.0f / 1.5f, 1.8f, 2.42f, 1e8f}) {
        EXPECT_EQ(DielectricF90(eta), 1.0f) << eta;
        if (eta < 1.0f) continue;
        const FacetFresnel fresnel = DielectricFresnel(Glass(0.0f, eta));
        for (float c = 0.0f; c <= 1.0f; c += 0.05f) {
            const float schlick = FresnelSchlick(c, DielectricF0(eta), 1.0f);
            EXPECT_EQ(FacetReflectance(fresnel, c, eta).y, schlick) << eta << " " << c;
            EXPECT_EQ(OutsideReflectance(fresnel, c, eta).y, schlick) << eta << " " << c;
        }
    }
    // Schlick's mean differs from Fresnel's there, as in the specification
    EXPECT_NEAR(SchlickMean(1.5f), 0.04 + 0.96 / 21.0, 1e-5);
}

TEST(Boundary, IceInADrinkHardlyShows) {
    const float eta = 1.31f / 1.33f;
    const FacetFresnel fresnel = DielectricFresnel(Glass(0.0f, eta));
    const float cosTheta = std::cos(70.0f * kPi / 180.0f);
    EXPECT_NEAR(FresnelDielectric(cosTheta, eta), 0.0044f, 1e-4f);
    EXPECT_NEAR(FacetReflectance(fresnel, cosTheta, eta).y, 0.0044f, 0.02f);
}

// A red layer: more of red is reflected, and the rest must not be what is left of white without red.
GltfBxDF RedLayer(float alpha) {
    GltfBxDF lobe = GltfLobe(alpha);
    lobe.specularColor = vec3(12.5f, 1.0f, 1.0f);  // F0 = (0.5, 0.04, 0.04)
    return lobe;
}

TEST(Boundary, BaseUnderAColoredLayerKeepsItsColor) {
    for (const float alpha : {0.0f, 0.2f, 0.8f}) {
        float pdf = 0.0f;
        vec3 diffuse(0.0f);
        const vec3 wo = DirectionAt(0.8f, 0.0f);
        Evaluate(Prepare(RedLayer(alpha), wo), DirectionAt(0.6f, 1.0f), false, pdf, diffuse);
        EXPECT_GT(diffuse.x, 0.05f) << alpha;
        EXPECT_EQ(diffuse.x, diffuse.y) << alpha;
        EXPECT_EQ(diffuse.y, diffuse.z) << alpha;
        const Albedo all = MeasureAlbedo(RedLayer(alpha), wo, 1u << 12);
        EXPECT_GT(all.reflected.x, all.reflected.y + 0.3) << alpha;
        EXPECT_LE(all.reflected.x, 1.015) << alpha;
    }
}

TEST(Boundary, LightThroughAColoredLayerKeepsItsColor) {
    for (const MultiscatterKind kind :
         {MultiscatterKind::Off, MultiscatterKind::Lut, MultiscatterKind::Walk}) {
        const MultiscatterScope scope(kind);
        for (const bool isThin : {false, true}) {
            GltfBxDF lobe = RedLayer(0.0f);
            lobe.transmission = 1.0f;
            lobe.isThin = isThin;
            const Albedo smooth = MeasureAlbedo(lobe, DirectionAt(1.0f, 0.0f), 1u << 12);
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(smooth.transmitted[c], 0.5, 0.01) << isThin;
            lobe.alpha = vec2(0.3f);
            const glm::dvec3 rough = MeasureAlbedo(lobe, DirectionAt(0.9f, 0.0f), 1u << 14).transmitted;
            EXPECT_NEAR(rough.x, rough.y, 0.04) << isThin;  // facets light each other red
        }
    }
}

class FresnelScope {
  public:
    explicit FresnelScope(FresnelModel model) { threadFresnelModel = model; }
    ~FresnelScope() { threadFresnelModel = FresnelModel::Schlick; }
    FresnelScope(const FresnelScope&) = delete;
    FresnelScope& operator=(const FresnelScope&) = delete;
};

TEST(Boundary, InfiniteIndexReflectsAllInEveryModel) {
    for (const FresnelModel model :
         {FresnelModel::Schlick, FresnelModel::Dielectric, FresnelModel::Conductor, FresnelModel::Lazanyi}) {
        const FresnelScope fresnel(model);
        for (const MultiscatterKind kind :
             {MultiscatterKind::Off, MultiscatterKind::Lut, MultiscatterKind::Walk}) {
            const MultiscatterScope multiscatter(kind);
            for (const float eta : {gpu::kInfiniteIor, 1.0f / gpu::kInfiniteIor})
                for (const float alpha : {0.0f, 0.05f, 0.4f})
                    for (const uint shape : {0u, 1u, 2u}) {
                        GltfBxDF lobe = Glass(alpha, eta);
                        lobe.baseColor = vec3(0.2f);
                        lobe.transmission = shape == 2u ? 0.0f : 1.0f;
                        lobe.isThin = shape == 1u;
                        const Albedo albedo = MeasureAlbedo(lobe, DirectionAt(0.6f, 0.2f), 1u << 10);
                        // One bounce alone loses much of a rough surface's light
                        const double lost = kind == MultiscatterKind::Off ? alpha : 0.05 * alpha;
                        EXPECT_NEAR(albedo.reflected.y, 1.0, lost + 1e-5)
                            << "model " << static_cast<int>(model) << " multiscatter "
                            << static_cast<int>(kind) << " eta " << eta << " alpha " << alpha << " shape "
                            << shape;
                        EXPECT_LT(albedo.transmitted.y, 1e-5);
                    }
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::boundary_test

// Lobes that no material of a scene has are left out of its pipelines (GLTF_LOBES, HasTraceFeature): nothing may
// read them then.
namespace raygraph::shading::lobe_features_test {
namespace {

class FeatureScope {
  public:
    explicit FeatureScope(TraceFeatures features) : m_before(threadTraceFeatures) {
        threadTraceFeatures = features;
    }
    ~FeatureScope() { threadTraceFeatures = m_before; }
    FeatureScope(const FeatureScope&) = delete;
    FeatureScope& operator=(const FeatureScope&) = delete;

  private:
    TraceFeatures m_before;
};

// Leaves NaN where the next function has its variables: a value that is read without having been set shows.
[[gnu::noinline]] void FillStack() {
    volatile float block[4096];
    for (volatile float& value : block) value = std::numeric_limits<float>::quiet_NaN();
}

struct Outcome {
    vec3 value{};
    float pdf = 0.0f;
    BSDFSample sample{};
};

[[gnu::noinline]] Outcome OutcomeOf(const GltfBxDF& lobe, vec3 wo, vec3 wi, float uc, vec2 u) {
    const GltfBSDF g = Prepare(lobe, wo);
    Outcome outcome;
    outcome.value = Evaluate(g, wi, outcome.pdf);
    outcome.sample = Sample_f(g, uc, u);
    return outcome;
}

void ExpectSame(const Outcome& a, const Outcome& b, const std::string& where) {
    EXPECT_EQ(std::bit_cast<uint>(a.pdf), std::bit_cast<uint>(b.pdf)) << where;
    EXPECT_EQ(std::bit_cast<uint>(a.sample.pdf), std::bit_cast<uint>(b.sample.pdf)) << where;
    EXPECT_EQ(a.sample.flags, b.sample.flags) << where;
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(std::bit_cast<uint>(a.value[i]), std::bit_cast<uint>(b.value[i])) << where;
        EXPECT_EQ(std::bit_cast<uint>(a.sample.f[i]), std::bit_cast<uint>(b.sample.f[i])) << where;
        EXPECT_EQ(std::bit_cast<uint>(a.sample.wi[i]), std::bit_cast<uint>(b.sample.wi[i])) << where;
    }
}

struct Case {
    const char* name;
    GltfBxDF lobe;
    TraceFeatures features;  // required features
};

std::vector<Case> Cases() {
    GltfBxDF faint = GltfLobe(0.3f);  // reflects so little that its layer is hardly ever chosen
    faint.specular = 1e-5f;
    GltfBxDF green = GltfLobe(0.3f);
    green.specularColor = vec3(0.1f, 1.0f, 0.5f);
    GltfBxDF almostGlass = Glass(0.3f, 1.5f);
    almostGlass.transmission = 1.0f - 1e-6f;
    GltfBxDF coated = Metal(0.3f, vec3(1.0f, 0.7f, 0.3f));
    coated.clearcoat = 0.5f;
    coated.clearcoatRoughness = 0.4f;
    coated.coatAlpha = 0.16f;
    GltfBxDF lacquered = coated;
    lacquered.clearcoatRoughness = lacquered.coatAlpha = 0.0f;
    GltfBxDF bubble = ThinGlass(0.3f);
    bubble.iridescence = 0.8f;
    bubble.iridescenceIor = 1.4f;
    bubble.iridescenceThickness = 300.0f;
    GltfBxDF brushed = Metal(0.3f, vec3(1.0f, 0.7f, 0.3f));
    brushed.alpha.x = 0.7f;
    std::vector<Case> cases{{"metal", Metal(0.3f, vec3(1.0f, 0.7f, 0.3f)), kTraceMetals},
                            {"dielectric", GltfLobe(0.3f), kTraceOpaque},
                            {"faint dielectric", faint, kTraceOpaque},
                            {"green dielectric", green, kTraceOpaque},
                            {"glass", Glass(0.3f, 1.5f), kTraceGlass},
                            {"almost glass", almostGlass, kTraceGlass | kTraceOpaque},
                            {"thin wall", ThinGlass(0.3f), kTraceGlass},
                            {"smooth thin wall", ThinGlass(0.0f), kTraceGlass | kTraceSmooth},
                            {"smooth metal", Metal(0.0f, vec3(0.9f)), kTraceMetals | kTraceSmooth},
                            {"coated metal", coated, kTraceMetals | kTraceClearcoat},
                            {"lacquered metal", lacquered, kTraceMetals | kTraceClearcoat | kTraceSmooth},
                            {"brushed metal", brushed, kTraceMetals | kTraceAnisotropy},
                            {"bubble", bubble, kTraceGlass | kTraceIridescence}};
    // Something of each lobe that has a feature of its own, over metal, glass and plastic
    GltfBxDF blend = Blend(0.3f);
    blend.coatAlpha = 0.16f;
    blend.iridescenceIor = 1.4f;
    blend.iridescenceThickness = 300.0f;
    const TraceFeatures base = kTraceMetals | kTraceGlass | kTraceOpaque;
    const auto lobeOf = [&](TraceFeatures feature) -> GltfBxDF& {
        for (Case& test : cases)
            if (test.features == (base | feature)) return test.lobe;
        return cases.emplace_back(Case{"blend", blend, base | feature}).lobe;
    };
#define RAYGRAPH_MATERIAL_FACTOR(type, name, object, key, channels, space, feature, quantity) \
    lobeOf(kTrace##feature).name = type(0.4f);
#include "shared/material_list.h"
    return cases;
}

TEST(LobeFeatures, LobesThatNoMaterialHasMayBeOff) {
    const TraceFeatures all = threadTraceFeatures;
    const TraceFeatures lobes = FeaturesOfKind(TraceFeatureKind::Lobes);
    std::vector<TraceFeatures> alsoOn{TraceFeatures{}};
    for (const TraceFeatureRow& row : kTraceFeatureRows)
        if (row.kind == TraceFeatureKind::Lobes) alsoOn.push_back(row.feature);
    for (const MultiscatterKind kind :
         {MultiscatterKind::Off, MultiscatterKind::Lut, MultiscatterKind::Walk}) {
        const MultiscatterScope scope(kind);
        for (const Case& test : Cases()) {
            for (const float cosine : {1.0f, 0.7f, 0.05f}) {
                const vec3 wo = DirectionAt(cosine, 0.8f);
                for (const float uc : {0.0f, 0.3f, 0.9f, 0.99999994f}) {
                    const vec3 wi = DirectionAt(uc < 0.5f ? 0.6f : -0.6f, 2.0f + uc);
                    const vec2 u(0.4f, 0.3f);
                    const Outcome whole = OutcomeOf(test.lobe, wo, wi, uc, u);
                    for (const TraceFeatures others : alsoOn) {
                        const FeatureScope features((all & ~lobes) | test.features | others);
                        FillStack();
                        ExpectSame(OutcomeOf(test.lobe, wo, wi, uc, u), whole,
                                   std::string(test.name) + ", multiscatter " + std::to_string(int(kind)) +
                                       ", cos " + std::to_string(cosine) + ", uc " + std::to_string(uc));
                    }
                }
            }
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::lobe_features_test
