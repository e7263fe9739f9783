// Materials under a thin film: their lobes, and the energy of the whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/shading/lone_lobe.h"

#include "bxdf/bsdf.glsl"

namespace raygraph::shading::iridescence_test {
namespace {

constexpr vec3 kUp(0.0f, 0.0f, 1.0f);

GltfBxDF Filmed(GltfBxDF base, float ior, float thickness, float weight = 1.0f) {
    base.iridescence = weight;
    base.iridescenceIor = ior;
    base.iridescenceThickness = thickness;
    // The media are in vacuum
    base.outerIor = std::max(1.0f / base.eta, 1.0f);
    return base;
}

struct Base {
    const char* name;
    GltfBxDF (*of)(float alpha);
};

const std::vector<Base> kWhiteBases = {
    {"dielectric", [](float alpha) { return GltfLobe(alpha); }},
    {"metal", [](float alpha) { return Metal(alpha, vec3(1.0f)); }},
    {"gray metal", [](float alpha) { return Metal(alpha, vec3(0.5f)); }},
    {"black metal", [](float alpha) { return Metal(alpha, vec3(0.0f)); }},
    {"glass from outside", [](float alpha) { return Glass(alpha, 1.5f); }},
    {"glass from inside", [](float alpha) { return Glass(alpha, 1.0f / 1.5f); }},
    {"thin wall", [](float alpha) { return ThinGlass(alpha); }}};

TEST(Iridescence, SamplesAgreeWithFAndPDF) {
    uint32_t seed = 6000;
    GltfBxDF thin = Blend(0.4f);
    thin.isThin = true;
    for (const GltfBxDF& base : {GltfLobe(0.4f), Metal(0.4f, vec3(0.2f, 0.5f, 0.9f)), thin, Glass(0.3f, 1.5f),
                                 Glass(0.3f, 1.0f / 1.5f)})
        for (const float cosine : {0.6f}) {
            const vec3 wo = DirectionAt(cosine, 0.8f);
            const Seen seen = SeenFrom(Filmed(base, 1.7f, 420.0f), wo);
            ExpectSamplesAgree(seen, wo, 1e-3f, 500);
            const test::ChiSquareResult result =
                ChiSquareOfLobe(seen, wo, {{PolarGrid{.ringCount = 40}}}, seed++);
            EXPECT_GT(result.pValue, 1e-4) << base.metallic << base.transmission << ", cos " << cosine;
        }
}

// Single scattering is reciprocal, whatever the film.
TEST(Iridescence, FacetsAreReciprocal) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    Uniform uniform(14);
    for (const Base& base : kWhiteBases) {
        GltfBxDF filmed = Filmed(base.of(0.4f), 1.8f, 380.0f);
        filmed.baseColor = min(filmed.baseColor, vec3(filmed.metallic > 0.0f ? 1.0f : 0.0f));
        for (int i = 0; i < 300; ++i) {
            vec3 wo = uniform.Direction(), wi = uniform.Direction();
            wo.z = std::max(std::abs(wo.z), 1e-3f);
            wi.z = std::max(std::abs(wi.z), 1e-3f);
            const vec3 forth = f(filmed, wo, wi);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(f(filmed, wi, wo)[c], forth[c], 2e-4f * (1e-3f + forth[c])) << base.name;
        }
    }
}

// f n^2 is the same both ways through a boundary.
TEST(Iridescence, RefractionIsReciprocal) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    Uniform uniform(15);
    const GltfBxDF outside = Filmed(Glass(0.4f, 1.5f), 1.8f, 380.0f);
    const GltfBxDF inside = Filmed(Glass(0.4f, 1.0f / 1.5f), 1.8f, 380.0f);
    int count = 0;
    for (int i = 0; i < 2000; ++i) {
        const vec3 wo = DirectionAt(0.1f + 0.9f * uniform(), 6.0f * uniform());
        const BSDFSample s = Sample_f(outside, wo, uniform(), uniform.Pair());
        if (s.pdf == 0.0f || s.wi.z > 0.0f) continue;
        ++count;
        const vec3 back = f(inside, vec3(s.wi.x, s.wi.y, -s.wi.z), vec3(wo.x, wo.y, -wo.z));
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(back[c], s.f[c] * 2.25f, 5e-3f * (1e-3f + back[c])) << wo.z << " " << s.wi.z;
    }
    EXPECT_GT(count, 1000);
}

TEST(Iridescence, SmoothGlassReflectsAndTransmitsAllOfEachChannel) {
    for (const bool isThin : {false, true})
        for (const float eta : {1.5f, 1.0f / 1.5f})
            for (const float cosine : {1.0f, 0.8f, 0.3f, 0.05f})
                for (const float thickness : {80.0f, 300.0f, 900.0f}) {
                    GltfBxDF glass = Filmed(Glass(0.0f, eta), 1.9f, thickness);
                    glass.isThin = isThin;
                    const Albedo albedo = MeasureAlbedo(glass, DirectionAt(cosine, 0.4f), 1u << 10u);
                    const glm::dvec3 lost = glm::abs(albedo.Sum() - 1.0);
                    EXPECT_LT(std::max({lost.x, lost.y, lost.z}), 3e-3)
                        << eta << ", cos " << cosine << ", " << thickness << " nm";
                }
}

// Nothing gains energy. Of rough glass the tables return all light within 2 % (1.5 % without a film), and walks
// are estimates.
TEST(Iridescence, WhiteFurnaceNeverGainsEnergy) {
    for (const MultiscatterKind kind : {MultiscatterKind::Lut, MultiscatterKind::Walk}) {
        const MultiscatterScope scope(kind);
        for (const Base& base : kWhiteBases) {
            double most = 0.0;
            for (const float roughness : {0.0f, 0.3f, 0.6f, 1.0f})
                for (const float cosine : {0.95f, 0.25f})
                    for (const float ior : {1.2f, 2.0f})
                        for (const float thickness : {90.0f, 300.0f, 1200.0f}) {
                            const GltfBxDF filmed = Filmed(base.of(roughness * roughness), ior, thickness);
                            const glm::dvec3 sum =
                                MeasureAlbedo(filmed, DirectionAt(cosine, 0.4f), 1u << 10u).Sum();
                            most = std::max({most, sum.x, sum.y, sum.z});
                        }
            const bool isExact = kind == MultiscatterKind::Lut && base.of(0.0f).transmission == 0.0f;
            EXPECT_LT(most, isExact ? 1.01 : 1.025) << base.name;
            const bool isWhite = base.of(0.0f).metallic == 0.0f || base.of(0.0f).baseColor.x == 1.0f;
            EXPECT_GT(most, isWhite ? 0.98 : 0.1) << base.name;
        }
    }
}

// A mean over the channels hides no gain: walks of what absorbs nothing lose nothing either.
TEST(Iridescence, WalksThroughGlassLoseNothing) {
    const MultiscatterScope scope(MultiscatterKind::Walk);
    for (const float eta : {1.5f, 1.0f / 1.5f})
        for (const bool isThin : {false, true}) {
            GltfBxDF filmed = Filmed(Glass(0.36f, eta), 1.7f, 330.0f);
            filmed.isThin = isThin;
            const glm::dvec3 sum = MeasureAlbedo(filmed, DirectionAt(0.6f, 0.4f), 1u << 15u).Sum();
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], 1.0, 6e-3) << eta << ", channel " << c;
        }
}

// The albedo that weights of sampling, later bounces and the base go by, against what the facets reflect.
TEST(Iridescence, TablesTakeAboutTheAlbedoOfTheFacets) {
    const MultiscatterScope scope(MultiscatterKind::Off);
    double worst = 0.0, squares = 0.0;
    int count = 0;
    for (const Base& base : {kWhiteBases[0], kWhiteBases[2], kWhiteBases[3]})
        for (const float roughness : {0.0f, 0.3f, 0.6f, 1.0f})
            for (const float cosine : {0.95f, 0.25f})
                for (const float ior : {1.2f, 2.0f})
                    for (const float thickness : {90.0f, 300.0f, 1200.0f}) {
                        GltfBxDF filmed = Filmed(base.of(roughness * roughness), ior, thickness);
                        const vec3 wo = DirectionAt(cosine, 0.4f);
                        const FacetView view = ViewOf(filmed, wo);
                        const bool isMetal = filmed.metallic > 0.0f;
                        const vec3 claimed =
                            isMetal ? Reflected(PlacedLobe<ConductorBxDF>(filmed, wo), view).albedo
                                    : Reflected(PlacedLobe<DielectricLayerBxDF>(filmed, wo), view).albedo;
                        if (!isMetal) filmed.baseColor = vec3(0.0f);
                        const glm::dvec3 seen = MeasureAlbedo(filmed, wo, 1u << 12u).Sum();
                        for (int c = 0; c < 3; ++c) {
                            const double error = std::abs(seen[c] - double{claimed[c]});
                            worst = std::max(worst, error);
                            squares += error * error;
                            ++count;
                        }
                    }
    EXPECT_LT(worst, 0.05);
    EXPECT_LT(std::sqrt(squares / count), 0.008);
}

// The base of a white dielectric gets what the channel that is reflected most leaves, and the whole has the
// colors of the film.
TEST(Iridescence, BaseIsNotTinted) {
    const vec3 wo = DirectionAt(0.8f, 0.3f);
    const GltfBxDF filmed = Filmed(GltfLobe(0.0f), 1.8f, 340.0f);
    const vec3 white = f(filmed, wo, DirectionAt(0.7f, 2.0f));
    EXPECT_EQ(white, vec3(white.x));
    GltfBxDF black = filmed;
    black.baseColor = vec3(0.0f);
    const glm::dvec3 film = MeasureAlbedo(black, wo, 1u << 10u).Sum();
    const glm::dvec3 whole = MeasureAlbedo(filmed, wo, 1u << 14u).Sum();
    EXPECT_GT(std::max({film.x, film.y, film.z}) - std::min({film.x, film.y, film.z}), 0.03);
    EXPECT_NEAR(std::max({whole.x, whole.y, whole.z}), 1.0, 5e-3);
    EXPECT_NEAR(whole.x - whole.z, film.x - film.z, 5e-3);
}

// The medium around a surface is known by its index: a film in water has an index relative to water.
TEST(Iridescence, FilmIsRelativeToTheMediumAround) {
    SurfaceMaterial material{};
    material.ior = 1.5f;
    material.iridescence = 1.0f;
    material.iridescenceIor = 1.33f;
    material.iridescenceThickness = 300.0f;
    SurfaceInteraction surface{};
    surface.material = material;
    surface.isFront = true;
    const Frame frame = FrameFromZ(kUp);
    const auto film = [&](float eta) {
        return DielectricFresnel(surface.material, SettingOf(surface, frame, eta, 0.0f, 1u)).film;
    };
    EXPECT_FLOAT_EQ(film(1.5f).eta, 1.33f) << "in vacuum";
    EXPECT_FLOAT_EQ(film(1.5f / 1.33f).eta, 1.0f) << "in water";
    EXPECT_FLOAT_EQ(film(1.5f).path, 2.0f * 1.33f * 300.0f);
    surface.isFront = false;
    EXPECT_FLOAT_EQ(film(1.5f).eta, 1.33f) << "the back of what is no volume";
    surface.material.flags = kMaterialVolume;
    EXPECT_FLOAT_EQ(film(1.0f / 1.5f).eta, 1.33f) << "from within glass in vacuum";
    EXPECT_FLOAT_EQ(film(1.33f / 1.5f).eta, 1.0f) << "from within glass in water";
    EXPECT_FLOAT_EQ(film(2.0f / 1.5f).eta, 1.33f / 1.5f) << "from within a bubble of lower index";
}

}  // namespace
}  // namespace raygraph::shading::iridescence_test
