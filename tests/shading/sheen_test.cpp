// Sheen: its distribution, what it reflects alone, and what it leaves to the material below.
#include "tests/shading/gltf_lobe.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raygraph::shading::sheen_test {
namespace {

// Sheen over nothing that reflects.
GltfBxDF Sheen(float roughness, vec3 color = vec3(1.0f)) {
    GltfBxDF sheen = GltfLobe(0.5f);
    sheen.baseColor = vec3(0.0f);
    sheen.specular = 0.0f;
    sheen.sheenColor = color;
    sheen.sheenRoughness = roughness;
    return sheen;
}

GltfBxDF Under(const GltfBxDF& sheen, GltfBxDF base) {
    base.sheenColor = sheen.sheenColor;
    base.sheenRoughness = sheen.sheenRoughness;
    return base;
}

TEST(Sheen, ProjectedAreaOfTheFibersIsOne) {
    for (const float alpha : {0.01f, 0.09f, 0.5f, 1.0f}) {
        double sum = 0.0;
        constexpr int kCount = 20'000;
        for (int i = 0; i < kCount; ++i) {
            const double cosine = std::sqrt((i + 0.5) / kCount);  // cos d(cos) is d(cos^2) / 2
            sum += M_PI / kCount * double{SheenD(alpha, static_cast<float>(cosine))};
        }
        EXPECT_NEAR(sum, 1.0, 3e-3) << alpha;
    }
}

// Conty and Kulla's fit at its own supporting values: equal on both sides of cos = 0.5, and 0 facing the fibers.
TEST(Sheen, MaskingIsContinuous) {
    for (const float alpha : {0.05f, 0.3f, 1.0f})
        EXPECT_NEAR(SheenLambda(alpha, 0.4999f), SheenLambda(alpha, 0.5001f),
                    2e-3f * SheenLambda(alpha, 0.5f));
}

TEST(Sheen, SamplesAgreeWithFAndPDF) {
    uint32_t seed = 5000;
    for (const float roughness : {0.2f, 0.5f, 1.0f})
        for (const float cosine : {0.9f, 0.2f}) {
            const vec3 wo = DirectionAt(cosine, 0.8f);
            const GltfBxDF sheen = Sheen(roughness, vec3(0.9f, 0.5f, 0.1f));
            ExpectSamplesAgree(sheen, wo, 1e-4f, 500);
            const test::ChiSquareResult result =
                ChiSquareOfLobe(SeenFrom(sheen, wo), wo, {{PolarGrid{}}}, seed++);
            EXPECT_GT(result.pValue, 1e-4) << roughness << ", cos " << cosine;
        }
}

TEST(Sheen, IsReciprocal) {
    Uniform uniform(13);
    const GltfBxDF sheen = Sheen(0.4f);
    for (int i = 0; i < 300; ++i) {
        vec3 wo = uniform.Direction(), wi = uniform.Direction();
        wo.z = std::max(std::abs(wo.z), 1e-3f);
        wi.z = std::max(std::abs(wi.z), 1e-3f);
        const float forth = f(sheen, wo, wi).x;
        EXPECT_NEAR(f(sheen, wi, wo).x, forth, 1e-4f * (1e-3f + forth));
    }
}

// The base is scaled smoothly by the sheen's albedo, down to 0 where upright fibers are not seen.
TEST(Sheen, IsReciprocalOverADiffuseBase) {
    Uniform uniform(14);
    GltfBxDF lambert = GltfLobe(0.5f);
    lambert.specular = 0.0f;
    for (const float roughness : {0.0f, 0.1f, 0.15f, 0.5f}) {
        const GltfBxDF both = Under(Sheen(roughness), lambert);
        for (int i = 0; i < 300; ++i) {
            vec3 wo = uniform.Direction(), wi = uniform.Direction();
            wo.z = std::max(std::abs(wo.z), 1e-3f);
            wi.z = std::max(std::abs(wi.z), 1e-3f);
            const float forth = f(both, wo, wi).x;
            EXPECT_NEAR(f(both, wi, wo).x, forth, 2e-4f * (1e-3f + forth))
                << roughness << ": " << wo.z << ", " << wi.z;
        }
    }
}

// The table is what the lobe reflects: by quadrature over the directions of the light, which the baker does in
// another way, and never more than comes in.
TEST(Sheen, AlbedoIsThatOfTheTable) {
    for (const float roughness : {0.1f, 0.3f, 0.6f, 1.0f})
        for (const float cosine : {0.05f, 0.2f, 0.5f, 0.95f}) {
            const vec3 wo = DirectionAt(cosine, 0.0f);
            const GltfBxDF sheen = Sheen(roughness);
            double albedo = 0.0;
            constexpr int kHeights = 600, kAngles = 200;
            for (int i = 0; i < kHeights; ++i) {
                const double v = (i + 0.5) / kHeights;
                for (int j = 0; j < kAngles; ++j) {
                    const vec3 wi = DirectionAt(static_cast<float>(v * v),
                                                static_cast<float>(2.0 * M_PI * (j + 0.5) / kAngles));
                    albedo +=
                        double{f(sheen, wo, wi).x} * v * v * 2.0 * v * 2.0 * M_PI / (kHeights * kAngles);
                }
            }
            const float alpha = std::max(roughness * roughness, kMinSheenAlpha);
            const double table = SheenEnergyAt(SpanAt(std::sqrt(alpha), kEnergyAlphaCount), cosine).x;
            EXPECT_NEAR(table, albedo, 0.01 + 0.02 * albedo) << roughness << ", cos " << cosine;
            EXPECT_LT(albedo, 1.005) << roughness << ", cos " << cosine;
        }
}

// A published value: with the masking of the paper, white sheen of roughness 1 seen from the front (Enterprise
// PBR's table and the quadrature of a separate program: 0.164).
TEST(Sheen, OfRoughnessOneReflectsASixthFromTheFront) {
    const double seen = MeasureAlbedo(Sheen(1.0f), vec3(0.0f, 0.0f, 1.0f), 1u << 14u).reflected.x;
    EXPECT_NEAR(seen, 0.1638, 2e-3);
}

TEST(Sheen, WhiteStaysWhiteUnderIt) {
    const std::pair<const char*, GltfBxDF> kBases[] = {
        {"dielectric", GltfLobe(0.3f)}, {"metal", Metal(0.3f)}, {"thin wall", ThinGlass(0.3f)}};
    for (const auto& [name, base] : kBases)
        for (const float roughness : {0.15f, 0.5f, 1.0f})
            for (const float cosine : {0.9f, 0.3f, 0.1f}) {
                const glm::dvec3 sum =
                    MeasureAlbedo(Under(Sheen(roughness), base), DirectionAt(cosine, 0.3f), 1u << 14u).Sum();
                EXPECT_NEAR(sum.x, 1.0, 0.04) << name << ", roughness " << roughness << ", cos " << cosine;
            }
}

// The base is scaled equally in all channels, by the largest one.
TEST(Sheen, DoesNotTintWhatIsBelow) {
    GltfBxDF lambert = GltfLobe(0.5f);
    lambert.specular = 0.0f;
    const vec3 wo = DirectionAt(0.4f, 0.3f);
    const glm::dvec3 alone = MeasureAlbedo(Sheen(0.5f, vec3(0.8f, 0.2f, 0.0f)), wo, 1u << 14u).reflected;
    const glm::dvec3 both =
        MeasureAlbedo(Under(Sheen(0.5f, vec3(0.8f, 0.2f, 0.0f)), lambert), wo, 1u << 14u).reflected;
    const glm::dvec3 below = both - alone;
    EXPECT_NEAR(below.x, below.z, 4e-3);
    EXPECT_NEAR(below.y, below.z, 4e-3);
    EXPECT_NEAR(both.x, 1.0, 0.01);
}

}  // namespace
}  // namespace raygraph::shading::sheen_test
