#include "tests/shading/gltf_lobe.h"

#include <gtest/gtest.h>

#include <random>

#include "core/frame.glsl"
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
        constexpr uint kCount = 100'000;
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
