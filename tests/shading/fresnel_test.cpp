// Fresnel's curves, and the reflectance of facets under a thin film.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "tests/shading/gltf_lobe.h"

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

// The reflectance of facets under a thin film, against Airy's formula.
namespace raygraph::shading::thin_film_test {
namespace {

using Complex = std::complex<double>;

class FresnelScope {
  public:
    explicit FresnelScope(FresnelModel model) : m_before(threadFresnelModel) { threadFresnelModel = model; }
    ~FresnelScope() { threadFresnelModel = m_before; }
    FresnelScope(const FresnelScope&) = delete;
    FresnelScope& operator=(const FresnelScope&) = delete;

  private:
    FresnelModel m_before;
};

constexpr std::array kModels = {FresnelModel::Schlick, FresnelModel::Dielectric, FresnelModel::Conductor,
                                FresnelModel::Lazanyi};

ThinFilm Film(float ior, float thickness, float weight = 1.0f, float outerIor = 1.0f) {
    SurfaceMaterial material{};
    material.iridescence = weight;
    material.iridescenceIor = ior;
    material.iridescenceThickness = thickness;
    return FilmOf(material, outerIor);
}

FacetFresnel Filmed(FacetFresnel fresnel, ThinFilm film) {
    fresnel.film = film;
    return fresnel;
}

FacetFresnel Dielectric(float eta) {
    return {vec3(DielectricF0(eta)), vec3(DielectricF90(eta)), vec3(1.0f), false, NoFilm()};
}

// ------------------------------------------------------------------------------------------------- reference

// The CIE 1931 color matching functions by the fits of C. Wyman, P.-P. Sloan and P. Shirley 2013, "Simple
// Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2). Wavelengths in nm.
double Lobe(double wavelength, double mean, double below, double above) {
    const double t = (wavelength - mean) / (wavelength < mean ? below : above);
    return std::exp(-0.5 * t * t);
}

glm::dvec3 ColorMatch(double w) {
    return {1.056 * Lobe(w, 599.8, 37.9, 31.0) + 0.362 * Lobe(w, 442.0, 16.0, 26.7) -
                0.065 * Lobe(w, 501.1, 20.4, 26.2),
            0.821 * Lobe(w, 568.8, 46.9, 40.5) + 0.286 * Lobe(w, 530.9, 16.3, 31.1),
            1.217 * Lobe(w, 437.0, 11.8, 36.0) + 0.681 * Lobe(w, 459.0, 26.0, 13.8)};
}

// CIE standard illuminant D65 from 380 to 780 nm.
double Daylight(double wavelength) {
    constexpr std::array kPower = {
        49.9755, 54.6482, 82.7549, 91.486,  93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923,
        108.811, 109.354, 107.802, 104.79,  107.689, 104.405, 104.046, 100.0,   96.3342, 95.788,  88.6856,
        90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091,
        74.349,  61.604,  69.8856, 75.087,  63.5927, 46.4182, 66.8054, 63.3828};
    const double place = std::clamp((wavelength - 380.0) / 10.0, 0.0, 40.0);
    const auto first = std::min(static_cast<size_t>(place), kPower.size() - 2);
    return std::lerp(kPower[first], kPower[first + 1], place - static_cast<double>(first));
}

// The mean of a function of the wavelength over the responses of linear sRGB under daylight.
template <typename Spectrum>
glm::dvec3 MeanOverSpectrum(Spectrum&& spectrum) {
    const glm::dmat3 toSrgb(3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314,
                            0.0415560, 1.0572252);
    glm::dvec3 sum(0.0), white(0.0);
    for (double w = 365.0; w < 825.0; w += 1.0) {
        const glm::dvec3 response = toSrgb * ColorMatch(w) * Daylight(w);
        sum += response * spectrum(w);
        white += response;
    }
    return sum / white;
}

// Airy's reflectance of a film between a medium of index 1 and a base, for unpolarized light; thickness in nm.
double Airy(double cosI, double film, Complex base, double thickness, double wavelength) {
    const double sin2 = 1.0 - cosI * cosI;
    const Complex u1 = cosI, u2 = std::sqrt(Complex(film * film - sin2)), u3 = std::sqrt(base * base - sin2);
    const Complex roundTrip = std::exp(Complex(0.0, 4.0 * M_PI * thickness / wavelength) * u2);
    const auto of = [&](Complex r12, Complex r23) {
        return std::norm((r12 + r23 * roundTrip) / (1.0 + r12 * r23 * roundTrip));
    };
    const Complex film2 = film * film, base2 = base * base;
    return 0.5 * of((u1 - u2) / (u1 + u2), (u2 - u3) / (u2 + u3)) +
           0.5 * of((film2 * u1 - u2) / (film2 * u1 + u2),
                    (base2 * u2 - film2 * u3) / (base2 * u2 + film2 * u3));
}

// Returns the change by the film if each channel of the base has its own index.
glm::dvec3 Gain(double cosI, double film, vec3 eta, vec3 k, double thickness) {
    glm::dvec3 gain;
    for (int i = 0; i < 3; ++i) {
        const Complex base(static_cast<double>(eta[i]), static_cast<double>(k[i]));
        const double bare = Airy(cosI, film, base, 0.0, 550.0);
        gain[i] = MeanOverSpectrum([&](double w) { return Airy(cosI, film, base, thickness, w) - bare; })[i];
    }
    return gain;
}

// ----------------------------------------------------------------------------------------------------- tests

TEST(ThinFilm, ResponsesAreThoseOfDaylight) {
    for (float path = 0.0f; path < 8000.0f; path += 40.0f) {
        const ComplexColor mean = SpectrumOf(path).once;
        const auto wave = [&](double w) { return 2.0 * M_PI * static_cast<double>(path) / w; };
        const glm::dvec3 re = MeanOverSpectrum([&](double w) { return std::cos(wave(w)); });
        const glm::dvec3 im = MeanOverSpectrum([&](double w) { return std::sin(wave(w)); });
        for (int i = 0; i < 3; ++i)
            EXPECT_LT(std::hypot(double{mean.re[i]} - re[i], double{mean.im[i]} - im[i]), 0.021)
                << path << " nm, channel " << i;
    }
    EXPECT_LT(MaxComponent(abs(SpectrumOf(0.0f).once.re - vec3(1.0f))), 1e-5f) << "gray stays gray";
}

TEST(ThinFilm, PowersOfAPathAreThoseOfItsMultiples) {
    for (const float path : {0.0f, 90.0f, 700.0f}) {
        const PathSpectrum one = SpectrumOf(path);
        for (const auto& [power, multiple] :
             {std::pair{one.twice, 2.0f}, std::pair{one.thrice, 3.0f}, std::pair{one.fourTimes, 4.0f}}) {
            const ComplexColor direct = SpectrumOf(multiple * path).once;
            EXPECT_LT(MaxComponent(abs(power.re - direct.re)), 2e-5f) << path << " * " << multiple;
            EXPECT_LT(MaxComponent(abs(power.im - direct.im)), 2e-5f) << path << " * " << multiple;
        }
    }
}

TEST(ThinFilm, GainIsThatOfAirysFormulaOverTheSpectrum) {
    struct Base {
        const char* name;
        vec3 eta, k;
    };
    const std::array kBases = {Base{"air", vec3(1.0f), vec3(0.0f)}, Base{"water", vec3(1.33f), vec3(0.0f)},
                               Base{"three", vec3(1.4f, 1.5f, 2.0f), vec3(0.0f)},
                               Base{"gold", vec3(0.143f, 0.375f, 1.442f), vec3(3.983f, 2.386f, 1.603f)},
                               Base{"iron", vec3(2.91f, 2.95f, 2.58f), vec3(3.09f, 2.93f, 2.77f)}};
    const std::array<std::pair<float, double>, 4> kAngles = {
        {{1.0f, 0.012}, {0.6f, 0.012}, {0.3f, 0.015}, {0.15f, 0.04}}};
    double most = 0.0;
    for (const Base& base : kBases)
        for (const auto& [cosine, tolerance] : kAngles)
            for (const float ior : {1.1f, 1.3f, 1.7f, 2.2f})
                for (const float thickness : {25.0f, 100.0f, 250.0f, 400.0f, 750.0f, 1200.0f}) {
                    const vec3 gain = FilmGain(Film(ior, thickness), cosine, base.eta, base.k);
                    const glm::dvec3 exact = Gain(double{cosine}, double{ior}, base.eta, base.k, thickness);
                    for (int i = 0; i < 3; ++i)
                        EXPECT_NEAR(gain[i], exact[i], tolerance)
                            << base.name << ", cos " << cosine << ", index " << ior << ", " << thickness
                            << " nm, channel " << i;
                    most = std::max(most, glm::length(exact));
                }
    EXPECT_GT(most, 0.4) << "some of these change the reflectance very much";
}

TEST(ThinFilm, AtNormalIncidenceTheFacetIsAirysByEveryFresnel) {
    for (const FresnelModel model : kModels) {
        const FresnelScope scope(model);
        for (const float thickness : {0.0f, 120.0f, 300.0f, 550.0f}) {
            const vec3 seen = FacetReflectance(Filmed(Dielectric(1.5f), Film(1.3f, thickness)), 1.0f, 1.5f);
            const glm::dvec3 exact =
                MeanOverSpectrum([&](double w) { return Airy(1.0, 1.3, 1.5, thickness, w); });
            EXPECT_LT(glm::length(glm::dvec3(seen) - exact), 0.004) << thickness << " nm";
        }
        // A metal of the color f0: by the index that each model gives it
        const ConductorFresnel metal = ConductorFromColor(vec3(0.9f, 0.7f, 0.3f), vec3(1.0f));
        const vec3 k = model == FresnelModel::Dielectric ? vec3(0.0f) : metal.k;
        const vec3 seen = ConductorReflectance(metal, Film(1.8f, 250.0f), 1.0f);
        for (int i = 0; i < 3; ++i) {
            const Complex index(double{metal.eta[i]}, double{k[i]});
            const double exact =
                MeanOverSpectrum([&](double w) { return Airy(1.0, 1.8, index, 250.0, w); })[i];
            EXPECT_NEAR(seen[i], std::clamp(exact, 0.0, 1.0), 0.012) << static_cast<int>(model);
        }
    }
}

TEST(ThinFilm, ThatIsNotThereToLightChangesNothing) {
    for (const FresnelModel model : kModels) {
        const FresnelScope scope(model);
        const FacetFresnel metal{vec3(0.9f, 0.5f, 0.0f), vec3(1.0f), vec3(1.0f), true, NoFilm()};
        for (const FacetFresnel& bare : {Dielectric(1.5f), metal})
            for (const float c : {1.0f, 0.7f, 0.2f, 0.01f}) {
                const vec3 without = FacetReflectance(bare, c, 1.5f);
                const auto change = [&](ThinFilm film) {
                    return MaxComponent(abs(FacetReflectance(Filmed(bare, film), c, 1.5f) - without));
                };
                EXPECT_EQ(change(Film(1.3f, 0.0f)), 0.0f) << "no thickness";
                EXPECT_EQ(change(Film(1.3f, 400.0f, 0.0f)), 0.0f) << "no weight";
                EXPECT_LT(change(Film(2.0f, 1e-3f)), 1e-4f) << "hardly any thickness, cos " << c;
                EXPECT_LT(change(Film(1.0f, 400.0f)), 2e-6f) << "air, cos " << c;
                EXPECT_LT(change(Film(1.33f, 400.0f, 1.0f, 1.33f)), 2e-6f) << "water in water, cos " << c;
                if (!bare.isMetal) {
                    EXPECT_LT(change(Film(1.5f, 400.0f)), 2e-6f) << "glass on glass, cos " << c;
                    EXPECT_GT(change(Film(2.0f, 90.0f)), c > 0.1f ? 0.05f : 0.0f) << "cos " << c;
                }
            }
    }
}

TEST(ThinFilm, WeightIsTheShareOfFacets) {
    const vec3 bare = FacetReflectance(Dielectric(1.5f), 0.6f, 1.5f);
    const vec3 whole = FacetReflectance(Filmed(Dielectric(1.5f), Film(1.8f, 300.0f)), 0.6f, 1.5f);
    const vec3 part = FacetReflectance(Filmed(Dielectric(1.5f), Film(1.8f, 300.0f, 0.3f)), 0.6f, 1.5f);
    EXPECT_LT(MaxComponent(abs(part - mix(bare, whole, 0.3f))), 1e-6f);
}

TEST(ThinFilm, ThickOnesAreGray) {
    const vec3 gain = FilmGain(Film(1.8f, 2e4f), 0.8f, vec3(1.5f), vec3(0.0f));
    EXPECT_GT(gain.x, 0.04f);
    EXPECT_EQ(gain, vec3(gain.x));
    for (const float thickness : {1e5f, 1e9f})
        EXPECT_LT(MaxComponent(abs(FilmGain(Film(1.8f, thickness), 0.8f, vec3(1.5f), vec3(0.0f)) - gain)),
                  1e-6f);
}

// The other side of a boundary reflects the same at the refracted angle; beyond it, reflection is total.
TEST(ThinFilm, ReflectsAlikeFromBothSides) {
    for (const FresnelModel model : kModels) {
        const FresnelScope scope(model);
        const FacetFresnel fresnel = Filmed(Dielectric(1.5f), Film(1.3f, 350.0f));
        for (float c = 0.05f; c <= 1.0f; c += 0.05f) {
            const FresnelCoefficients outside = EvaluateFresnel(fresnel, c, 1.5f);
            const FresnelCoefficients inside =
                EvaluateFresnel(fresnel, RefractedCosine(c, 1.5f), 1.0f / 1.5f);
            EXPECT_LT(MaxComponent(abs(outside.reflected - inside.reflected)), 2e-4f) << c;
            EXPECT_LT(MaxComponent(abs(outside.passed - inside.passed)), 2e-4f) << c;
        }
        EXPECT_EQ(EvaluateFresnel(fresnel, 0.7f, 1.0f / 1.5f).reflected, vec3(1.0f));
        EXPECT_EQ(EvaluateFresnel(fresnel, 0.7f, 1.0f / 1.5f).passed, vec3(0.0f));
    }
}

TEST(ThinFilm, WhatIsNotReflectedPassesInEachChannel) {
    const FacetFresnel fresnel = Filmed(Dielectric(1.5f), Film(1.9f, 300.0f));
    for (float c = 0.02f; c < 1.0f; c += 0.02f) {
        const FresnelCoefficients shares = EvaluateFresnel(fresnel, c, 1.5f);
        EXPECT_LT(MaxComponent(abs(shares.reflected + shares.passed - vec3(1.0f))), 1e-6f) << c;
    }
    // A tinted base passes what it did, less what the film takes
    FacetFresnel red = fresnel;
    red.f0.y = red.f0.z = 0.0f;
    const FresnelCoefficients bare = EvaluateFresnel(Filmed(red, NoFilm()), 0.9f, 1.5f);
    EXPECT_NEAR(bare.passed.y, 1.0f - bare.reflected.x, 1e-6f);
    const FresnelCoefficients shares = EvaluateFresnel(red, 0.9f, 1.5f);
    EXPECT_LT(MaxComponent(abs(shares.passed + shares.reflected - bare.passed - bare.reflected)), 1e-6f);
}

// A slit of lower index between glass and glass: beyond total reflection light tunnels through a thin one.
TEST(ThinFilm, LightTunnelsThroughOneOfLowerIndex) {
    for (const float thickness : {5.0f, 30.0f, 100.0f, 300.0f})
        for (const float cosine : {0.7f, 0.6f, 0.3f}) {
            const vec3 gain =
                FilmGain(Film(1.0f, thickness, 1.0f, 1.5f), cosine, vec3(1.6f / 1.5f), vec3(0.0f));
            const glm::dvec3 exact =
                Gain(double{cosine}, 1.0 / 1.5, vec3(1.6f / 1.5f), vec3(0.0f), 1.5 * double{thickness});
            EXPECT_LT(glm::length(glm::dvec3(gain) - exact), 0.03)
                << thickness << " nm, cos " << cosine << ": " << gain.y << ", exact " << exact.y;
        }
    const vec3 wide = FilmGain(Film(1.0f, 3000.0f, 1.0f, 1.5f), 0.6f, vec3(1.6f / 1.5f), vec3(0.0f));
    EXPECT_GT(wide.y, 0.9f) << "all is reflected";
}

// Linear sRGB lacks the purest of these colors: this far they are outside, and clamped.
TEST(ThinFilm, ColorsLeaveTheGamut) {
    float least = 0.0f, most = 0.0f;
    for (const float k : {0.0f, 2.0f, 6.0f})
        for (const float eta : {1.0f, 1.5f, 2.0f})
            for (const float ior : {1.1f, 1.3f, 1.5f, 1.8f, 2.4f})
                for (float c = 0.05f; c <= 1.0f; c += 0.05f)
                    for (float thickness = 20.0f; thickness < 1200.0f; thickness += 20.0f) {
                        const vec3 bare = FresnelConductor(c, vec3(eta), vec3(k));
                        const vec3 r = bare + FilmGain(Film(ior, thickness), c, vec3(eta), vec3(k));
                        least = std::min({least, r.x, r.y, r.z});
                        most = std::max({most, r.x, r.y, r.z});
                    }
    EXPECT_NEAR(least, -0.12f, 0.01f);
    EXPECT_NEAR(most, 1.18f, 0.01f);
}

}  // namespace
}  // namespace raygraph::shading::thin_film_test
