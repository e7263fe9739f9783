#include "bxdf/facet_fresnel.glsl"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

namespace raygraph::shading::fresnel_test {
namespace {

constexpr std::array kIndices = {1.1f, 1.5f, 2.4f, 1.0f / 1.5f};

class ScopedFresnel {
  public:
    explicit ScopedFresnel(FresnelModel model) { threadFresnelModel = model; }
    ~ScopedFresnel() { threadFresnelModel = FresnelModel::Schlick; }
    ScopedFresnel(const ScopedFresnel&) = delete;
    ScopedFresnel& operator=(const ScopedFresnel&) = delete;
};

struct Metal {
    const char* name;
    vec3 eta;
    vec3 k;
};

// Indices near 650, 550 and 450 nm.
const std::array kMetals = {Metal{"aluminium", vec3(1.35f, 0.97f, 0.62f), vec3(7.47f, 6.40f, 5.30f)},
                            Metal{"gold", vec3(0.143f, 0.375f, 1.442f), vec3(3.983f, 2.386f, 1.603f)},
                            Metal{"copper", vec3(0.200f, 0.924f, 1.102f), vec3(3.912f, 2.452f, 2.142f)},
                            Metal{"iron", vec3(2.91f, 2.95f, 2.58f), vec3(3.09f, 2.93f, 2.77f)},
                            Metal{"silver", vec3(0.155f, 0.117f, 0.138f), vec3(4.828f, 3.122f, 2.147f)}};

// Returns Schlick's reflectance of an untinted dielectric facet, with the arguments of FresnelDielectric.
float SchlickOfFacet(float cosTheta, float eta) {
    const float ahead = cosTheta < 0.0f ? 1.0f / eta : eta;
    const FacetFresnel fresnel{vec3(DielectricF0(eta)), vec3(DielectricF90(eta)), vec3(1.0f), false};
    return FacetReflectance(fresnel, std::abs(cosTheta), ahead).x;
}

// Fresnel's amplitudes with complex numbers, in double.
double ComplexReflectance(double cosI, std::complex<double> eta) {
    const std::complex<double> sinT = std::sqrt(1.0 - cosI * cosI) / eta;
    const std::complex<double> cosT = std::sqrt(1.0 - sinT * sinT);
    const std::complex<double> parallel = (eta * cosI - cosT) / (eta * cosI + cosT);
    const std::complex<double> perpendicular = (cosI - eta * cosT) / (cosI + eta * cosT);
    return 0.5 * (std::norm(parallel) + std::norm(perpendicular));
}

TEST(Fresnel, DielectricIsFresnelsEquationsFromBothSides) {
    for (float eta : kIndices) {
        for (float c = 0.01f; c < 1.0f; c += 0.03f) {
            const double above = ComplexReflectance(c, static_cast<double>(eta));
            EXPECT_NEAR(FresnelDielectric(c, eta), above, 3e-6) << eta << " " << c;
            const double below = ComplexReflectance(c, 1.0 / static_cast<double>(eta));
            EXPECT_NEAR(FresnelDielectric(-c, eta), below, 3e-6) << eta << " " << c;
        }
        EXPECT_NEAR(FresnelDielectric(1.0f, eta), DielectricF0(eta), 1e-6f);
        EXPECT_NEAR(FresnelDielectric(-1.0f, eta), DielectricF0(eta), 1e-6f);
        EXPECT_EQ(FresnelDielectric(0.0f, eta), 1.0f);
    }
    EXPECT_NEAR(DielectricF0(1.5f), 0.04f, 1e-7f);
}

TEST(Fresnel, AtBrewstersAngleOnePolarizationIsNotReflected) {
    for (float eta : kIndices) {
        const float cosTheta = 1.0f / std::sqrt(1.0f + eta * eta);
        const float rest = (eta * eta - 1.0f) / (eta * eta + 1.0f);
        EXPECT_NEAR(FresnelDielectric(cosTheta, eta), 0.5f * rest * rest, 2e-6f) << eta;
    }
}

TEST(Fresnel, BeyondTheCriticalAngleEverythingIsReflected) {
    for (float eta : {1.1f, 1.5f, 2.4f}) {
        const float critical = std::sqrt(1.0f - 1.0f / (eta * eta));
        for (float share : {0.0f, 0.3f, 0.999f}) {
            EXPECT_EQ(FresnelDielectric(-critical * share, eta), 1.0f);
            EXPECT_EQ(FresnelDielectric(critical * share, 1.0f / eta), 1.0f);
            EXPECT_EQ(SchlickOfFacet(critical * share, 1.0f / eta), 1.0f);
            EXPECT_EQ(RefractedCosine(critical * share, 1.0f / eta), -1.0f);
        }
        EXPECT_LT(FresnelDielectric(-critical - 0.01f, eta), 0.99f);
        EXPECT_LT(SchlickOfFacet(-critical - 0.01f, eta), 0.99f);
        for (float c : {0.1f, 0.5f, 1.0f}) EXPECT_LT(FresnelDielectric(c, eta), 1.0f);
    }
}

TEST(Fresnel, BothEndsOfARefractedPathSeeOneReflectance) {
    for (float eta : kIndices) {
        for (float c = 0.05f; c <= 1.0f; c += 0.05f) {
            const float cosT = RefractedCosine(c, eta);
            if (cosT < 0.05f) continue;
            EXPECT_NEAR(FresnelDielectric(c, eta), FresnelDielectric(-cosT, eta), 2e-5f);
            EXPECT_NEAR(SchlickOfFacet(c, eta), SchlickOfFacet(-cosT, eta), 2e-5f);
        }
    }
}

TEST(Fresnel, ConductorIsFresnelsEquationsWithAComplexIndex) {
    for (const Metal& metal : kMetals) {
        for (float c = 0.0f; c <= 1.0f; c += 0.02f) {
            const vec3 reflected = FresnelConductor(c, metal.eta, metal.k);
            for (int i = 0; i < 3; ++i) {
                const std::complex<double> eta(metal.eta[i], -metal.k[i]);
                EXPECT_NEAR(reflected[i], ComplexReflectance(c, eta), 3e-5) << metal.name << " " << c;
            }
        }
        EXPECT_NEAR(ConductorF0(metal.eta, metal.k).x, FresnelConductor(1.0f, metal.eta, metal.k).x, 1e-5f);
    }
    for (float eta : kIndices)
        EXPECT_NEAR(FresnelConductor(0.9f, vec3(eta), vec3(0.0f)).x, FresnelDielectric(0.9f, eta), 2e-6f);
}

// Returns the largest error of the curve over all angles and channels.
float WorstError(FresnelModel model, const Metal& metal) {
    const ScopedFresnel active(model);
    const ConductorFresnel fresnel = ConductorFromIndices(metal.eta, metal.k);
    float worst = 0.0f;
    for (float c = 0.0f; c <= 1.0f; c += 0.01f) {
        const vec3 error = abs(ConductorReflectance(fresnel, c) - FresnelConductor(c, metal.eta, metal.k));
        worst = std::max(worst, MaxComponent(error));
    }
    return worst;
}

TEST(Fresnel, LazanyisTermMendsSchlicksCurveForMetals) {
    for (const Metal& metal : kMetals) {
        const float schlick = WorstError(FresnelModel::Schlick, metal);
        const float lazanyi = WorstError(FresnelModel::Lazanyi, metal);
        EXPECT_LT(lazanyi, 0.03f) << metal.name;
        EXPECT_LT(lazanyi, schlick) << metal.name;
        // Where Schlick's curve is far off, the term takes away most of that.
        EXPECT_TRUE(schlick < 0.1f || lazanyi < 0.15f * schlick)
            << metal.name << " " << schlick << " " << lazanyi;
        EXPECT_EQ(WorstError(FresnelModel::Conductor, metal), 0.0f);

        const ScopedFresnel active(FresnelModel::Lazanyi);
        const ConductorFresnel fresnel = ConductorFromIndices(metal.eta, metal.k);
        const vec3 exact = FresnelConductor(kLazanyiPeak, metal.eta, metal.k);
        EXPECT_LT(MaxComponent(abs(ConductorReflectance(fresnel, kLazanyiPeak) - exact)), 1e-5f)
            << metal.name;
    }
}

TEST(Fresnel, EveryModelReflectsF0AtNormalIncidenceAndAShareAtAnyAngle) {
    for (auto model :
         {FresnelModel::Schlick, FresnelModel::Dielectric, FresnelModel::Conductor, FresnelModel::Lazanyi}) {
        const ScopedFresnel active(model);
        for (float f0 : {0.0f, 0.04f, 0.5f, 0.95f, 1.0f}) {
            const ConductorFresnel fresnel = ConductorFromColor(vec3(f0), vec3(1.0f));
            EXPECT_NEAR(ConductorReflectance(fresnel, 1.0f).x, f0, 3e-4f) << static_cast<int>(model);
            // A dielectric without contrast is not there; Schlick's curve is.
            const float grazing = ConductorReflectance(fresnel, 0.0f).x;
            EXPECT_TRUE(f0 == 0.0f || std::abs(grazing - 1.0f) < 1e-5f) << static_cast<int>(model);
            for (float c = -0.1f; c <= 1.1f; c += 0.01f) {
                const float reflected = ConductorReflectance(fresnel, c).x;
                ASSERT_TRUE(reflected >= 0.0f && reflected <= 1.00001f) << c << " " << reflected;
            }
        }
    }
}

TEST(Fresnel, CosinesBeyondOneAreTakenAsOne) {
    const float above = 1.000001f;
    EXPECT_EQ(FresnelDielectric(above, 1.5f), FresnelDielectric(1.0f, 1.5f));
    EXPECT_EQ(FresnelDielectric(-above, 1.5f), FresnelDielectric(-1.0f, 1.5f));
    EXPECT_EQ(FresnelSchlick(above, 0.04f, 1.0f), 0.04f);
    EXPECT_EQ(FresnelConductor(above, vec3(1.5f), vec3(2.0f)),
              FresnelConductor(1.0f, vec3(1.5f), vec3(2.0f)));
}

}  // namespace
}  // namespace raygraph::shading::fresnel_test
