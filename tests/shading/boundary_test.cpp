// Boundaries between media, and how much light a colored layer passes to the lobes below it.
#include <gtest/gtest.h>

#include <algorithm>

#include "shared/scene_records.h"
#include "tests/shading/gltf_lobe.h"

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
