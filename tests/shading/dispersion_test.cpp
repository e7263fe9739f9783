// Media that refract colors differently: the bands of wavelengths, and paths through a half space of glass with
// a floor that shines.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "scene/ray.glsl"
#include "tests/shading/light_scene.h"
#include "tests/support/energy_bridge.h"

#include "bxdf/bsdf.glsl"

namespace raygraph::shading {

namespace {

// Glass below z = 0, without an end, and in it at z = -1 a black floor that emits 3 + x.
constexpr uint kGlass = 0u, kFloor = 1u;
thread_local float glassDispersion = 0.0f;
thread_local float filmWeight = 0.0f;  // weight of a film with the index of air
constexpr float kIor = 1.6f;

Hit Intersect(Ray ray, uint) {
    Hit hit{};
    hit.t = -1.0f;
    for (const uint plane : {kGlass, kFloor}) {
        const float t = (-float(plane) - ray.origin.z) / ray.direction.z;
        if (!(t > 0.0f) || (hit.t >= 0.0f && t > hit.t)) continue;
        hit.t = t;
        hit.instance = plane;
    }
    return hit;
}

SurfaceInteraction SurfaceAt(Hit hit, Ray ray) {
    SurfaceInteraction surface{};
    surface.position = ray.origin + hit.t * ray.direction;
    surface.fromInstance = surface.position;
    surface.isFront = ray.direction.z < 0.0f;
    surface.geometricNormal = vec3(0.0f, 0.0f, surface.isFront ? 1.0f : -1.0f);
    surface.shadingNormal = surface.geometricNormal;
    surface.clearance = 1e-5f;
    surface.light = kNoLight;
    surface.material.id = hit.instance;
    surface.material.specular = 1.0f;
    surface.material.specularColor = vec3(1.0f);
    surface.material.ior = kIor;
    if (hit.instance == kGlass) {
        surface.material.baseColor = vec3(1.0f);
        surface.material.transmission = 1.0f;
        surface.material.flags = kMaterialVolume;
        surface.material.iridescence = filmWeight;
        surface.material.iridescenceIor = 1.0f;
        surface.material.iridescenceThickness = 500.0f;
    } else {
        surface.emission = vec3(3.0f + surface.position.x);
        surface.material.metallic = 1.0f;
    }
    return surface;
}

vec3 ShadowTransmittance(Ray, float, float, uint) {
    return vec3(0.0f);
}

Medium MediumAt(uint) {
    return {.extinction = vec3(0.0f),
            .scattering = vec3(0.0f),
            .anisotropy = 0.0f,
            .ior = kIor,
            .dispersion = glassDispersion,
            .priority = 0u};
}

}  // namespace

}  // namespace raygraph::shading

// The bridge is declared: now the integrator over it.
#include "integrator/extend_path.glsl"

namespace raygraph::shading::dispersion_test {

namespace {

// Other tests find the options as they were.
class Dispersion : public ::testing::Test {
  protected:
    Dispersion() {
        threadTraceFeatures = kTraceSmooth | kTraceGlass | kTraceMetals | kTraceVolumes | kTraceDispersion;
        threadBrdfModel = BrdfModel::Gltf;
        testLights = {};
    }
    ~Dispersion() override {
        threadTraceFeatures = m_features;
        threadBrdfModel = m_brdf;
        glassDispersion = 0.0f;
        filmWeight = 0.0f;
    }

  private:
    const TraceFeatures m_features = threadTraceFeatures;
    const BrdfModel m_brdf = threadBrdfModel;
};

// The integral of a function of the wavelength over each color's band.
glm::dvec3 OverBands(const std::function<double(double)>& value) {
    glm::dvec3 sum(0.0);
    for (double wavelength = 250.5; wavelength < 900.0; ++wavelength)
        sum += glm::dvec3(BandDensity(float(wavelength))) * value(wavelength);
    return sum;
}

}  // namespace

// The color matching functions are the fits by Wyman, Sloan and Shirley 2013, "Simple Analytic Approximations
// to the CIE XYZ Color Matching Functions", equation 4, with the matrix of linear sRGB.
TEST_F(Dispersion, BandsHaveMeanAndDeviationOfTheColorMatchingFunctions) {
    const auto lobe = [](double x, double center, double below, double above) {
        const double t = (x - center) * (x < center ? below : above);
        return std::exp(-0.5 * t * t);
    };
    glm::dvec3 sums(0.0), means(0.0), squares(0.0);
    for (double l = 380.0; l < 780.0; ++l) {
        const double x = 0.362 * lobe(l, 442.0, 0.0624, 0.0374) + 1.056 * lobe(l, 599.8, 0.0264, 0.0323) -
                         0.065 * lobe(l, 501.1, 0.0490, 0.0382);
        const double y = 0.821 * lobe(l, 568.8, 0.0213, 0.0247) + 0.286 * lobe(l, 530.9, 0.0613, 0.0322);
        const double z = 1.217 * lobe(l, 437.0, 0.0845, 0.0278) + 0.681 * lobe(l, 459.0, 0.0385, 0.0725);
        glm::dvec3 rgb(3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                       -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                       0.0556434 * x - 0.2040259 * y + 1.0572252 * z);
        rgb = glm::max(rgb, 0.0);
        if (l < 480.0) rgb.x = 0.0;  // the violet part
        sums += rgb;
        means += l * rgb;
        squares += l * l * rgb;
    }
    means /= sums;
    for (int color = 0; color < 3; ++color) {
        const double deviation = std::sqrt(squares[color] / sums[color] - means[color] * means[color]);
        EXPECT_NEAR(kBandMean[color], means[color], 0.2) << color;
        EXPECT_NEAR(kBandScale[color], deviation * std::sqrt(3.0) / double(kPi), 0.02) << color;
    }
}

TEST_F(Dispersion, SharesOfTheWavelengthsDrawnHaveTheMeanOne) {
    constexpr uint kCount = 1u << 18;
    glm::dvec3 sum(0.0), middle(0.0);
    for (uint i = 0; i < kCount; ++i) {
        const float wavelength = SampleWavelength((float(i) + 0.5f) / float(kCount));
        const vec3 share = WavelengthShare(wavelength);
        ASSERT_NEAR(share.x + share.y + share.z, 3.0f, 1e-5f) << wavelength;
        sum += glm::dvec3(share);
        middle += glm::dvec3(share) * double(wavelength);
    }
    for (int color = 0; color < 3; ++color) {
        EXPECT_NEAR(sum[color] / kCount, 1.0, 1e-4) << color;
        EXPECT_NEAR(middle[color] / kCount, kBandMean[color], 0.05) << color;
    }
    const glm::dvec3 whole = OverBands([](double) { return 1.0; });
    for (int color = 0; color < 3; ++color) EXPECT_NEAR(whole[color], 1.0, 1e-4) << color;
}

TEST_F(Dispersion, IndexHasTheAbbeNumberThatTheFileSays) {
    for (const float abbe : {20.0f, 55.0f, 89.0f}) {
        const float value = 20.0f / abbe;
        const float d = DispersedIor(kIor, value, 587.56f);
        EXPECT_NEAR(d, kIor, 2e-5f * value);
        const double spread =
            double{DispersedIor(kIor, value, 486.13f)} - double{DispersedIor(kIor, value, 656.27f)};
        EXPECT_NEAR((kIor - 1.0) / spread, abbe, 1e-3 * abbe);
    }
    EXPECT_EQ(DispersedIor(kIor, 7.0f, kNoWavelength), kIor);
    EXPECT_EQ(DispersedIor(1.1f, 100.0f, 1200.0f), 1.0f) << "not below that of vacuum";
}

// Through the surface, refracted by Snell's law at each wavelength, to the floor: the mean of a function that is
// linear in the place that is seen there, times what Fresnel's law lets pass.
TEST_F(Dispersion, ColorsSeeTheFloorWhereTheirWavelengthsRefractTo) {
    const double sinI = std::sin(1.1), cosI = std::cos(1.1);
    const Ray ray{.origin = vec3(-sinI, 0.0f, cosI), .direction = vec3(sinI, 0.0f, -cosI)};
    const PathSettings settings{.maxDepth = 8u,
                                .rouletteStart = 100u,
                                .survival = 1.0f,
                                .frameDepth = 0u,
                                .clampIndirect = kInfinity,
                                .regularize = 0.0f};
    for (const float value : {0.36f, 4.0f}) {
        glassDispersion = value;
        constexpr uint kCount = 1u << 16;
        glm::dvec3 sum(0.0), squares(0.0);
        for (uint i = 0; i < kCount; ++i) {
            PathState path = StartPath(ray, StartPixelSample(uvec2(3u, 5u), i, 9u));
            while (ExtendPath(path, settings)) {
            }
            sum += glm::dvec3(path.radiance);
            squares += glm::dvec3(path.radiance) * glm::dvec3(path.radiance);
        }
        const glm::dvec3 expected = OverBands([&](double wavelength) {
            const double n = DispersedIor(kIor, value, float(wavelength));
            const double sinT = sinI / n;
            const double f0 = std::pow((n - 1.0) / (n + 1.0), 2.0);
            const double passed = (1.0 - f0) * (1.0 - std::pow(1.0 - cosI, 5.0));
            return passed / (n * n) * (3.0 + sinT / std::sqrt(1.0 - sinT * sinT));
        });
        for (int color = 0; color < 3; ++color) {
            const double mean = sum[color] / kCount;
            const double error = std::sqrt((squares[color] / kCount - mean * mean) / kCount);
            EXPECT_LT(error, 0.01 * mean);
            EXPECT_NEAR(mean, expected[color], 4.0 * error + 2e-4) << "dispersion " << value << ", " << color;
        }
        EXPECT_GT(expected.x - expected.z, 20.0 * 0.001 * double{value}) << "nothing to see";
    }
}

// Without dispersion no wavelength is drawn: a path keeps all colors.
TEST_F(Dispersion, PathsThroughOtherGlassKeepAllColors) {
    const Ray ray{.origin = vec3(0.0f, 0.0f, 1.0f), .direction = normalize(vec3(0.4f, 0.0f, -1.0f))};
    const PathSettings settings{.maxDepth = 8u,
                                .rouletteStart = 100u,
                                .survival = 1.0f,
                                .frameDepth = 0u,
                                .clampIndirect = kInfinity,
                                .regularize = 0.0f};
    for (uint i = 0; i < 64u; ++i) {
        PathState path = StartPath(ray, StartPixelSample(uvec2(3u, 5u), i, 9u));
        while (ExtendPath(path, settings)) {
        }
        EXPECT_EQ(path.wavelength, kNoWavelength);
        EXPECT_EQ(path.throughput.x, path.throughput.z);
        EXPECT_EQ(path.radiance.x, path.radiance.z);
    }
}

// A film of the index of what is before it is not there, at any wavelength: its index is relative to that of the
// path's own.
TEST_F(Dispersion, FilmOfTheIndexOfAirChangesNothing) {
    threadTraceFeatures |= kTraceIridescence;
    const PathSettings settings{.maxDepth = 8u,
                                .rouletteStart = 100u,
                                .survival = 1.0f,
                                .frameDepth = 0u,
                                .clampIndirect = kInfinity,
                                .regularize = 0.0f};
    glassDispersion = 5.0f;
    for (const bool isInside : {false, true}) {
        const Ray ray{.origin = vec3(0.0f, 0.0f, isInside ? -0.5f : 1.0f),
                      .direction = normalize(vec3(0.4f, 0.0f, isInside ? 1.0f : -1.0f))};
        testLights.environmentTint = vec3(1.0f);
        vec3 sums[2] = {vec3(0.0f), vec3(0.0f)};
        for (const float weight : {0.0f, 1.0f}) {
            filmWeight = weight;
            for (uint i = 0; i < 4096u; ++i) {
                PathState path = StartPath(ray, StartPixelSample(uvec2(3u, 5u), i, 9u));
                if (isInside) path.media = EnterMedium(NoMedia(), kGlass);
                while (ExtendPath(path, settings)) {
                }
                sums[weight > 0.0f ? 1 : 0] += path.radiance / 4096.0f;
            }
        }
        testLights.environmentTint = vec3(0.0f);
        for (int color = 0; color < 3; ++color)
            EXPECT_NEAR(sums[1][color], sums[0][color], 2e-4f * sums[0][color]) << isInside << ", " << color;
    }
}

}  // namespace raygraph::shading::dispersion_test
