#include "tests/support/energy_bridge.h"

#include "bxdf/diffuse.glsl"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/rng.glsl"
#include "tests/support/chi_square.h"

namespace raygraph::shading::diffuse_test {
namespace {

DiffuseBxDF Lobe(vec3 albedo) {
    DiffuseBxDF lobe;
    lobe.albedo = albedo;
    return lobe;
}

vec3 Direction(float cosTheta, float phi) {
    const float sinTheta = std::sqrt(1.0f - cosTheta * cosTheta);
    return vec3(sinTheta * std::cos(phi), sinTheta * std::sin(phi), cosTheta);
}

// Returns directions from straight above to grazing, and from below.
std::vector<vec3> Viewers() {
    return {Direction(1.0f, 0.0f), Direction(0.7f, 1.0f), Direction(0.01f, 4.0f), Direction(-0.5f, 2.0f)};
}

const vec3 kAlbedo(0.8f, 0.5f, 0.1f);

TEST(Lambert, SampledDirectionsFollowPDF) {
    const double level = test::SidakLevel(0.01, static_cast<int>(Viewers().size()));
    uint32_t seed = 100;
    for (vec3 wo : Viewers()) {
        const auto sample = [&](float uc, vec2 u) -> std::optional<vec3> {
            const BSDFSample s = Sample_f(Lobe(kAlbedo), wo, uc, u);
            if (s.pdf == 0.0f) return std::nullopt;
            return s.wi;
        };
        const auto pdf = [&](vec3 wi) { return static_cast<double>(PDF(Lobe(kAlbedo), wo, wi)); };
        EXPECT_GT(test::ChiSquareOfDirections(sample, pdf, {.seed = seed++}).pValue, level) << wo.z;
    }
}

TEST(Lambert, PDFIntegratesToOne) {
    for (vec3 wo : Viewers()) {
        const auto pdf = [&](vec3 wi) { return static_cast<double>(PDF(Lobe(kAlbedo), wo, wi)); };
        EXPECT_NEAR(test::IntegrateOverSphere(pdf, -1.0, 0.0, 0.0, 2.0 * M_PI) +
                        test::IntegrateOverSphere(pdf, 0.0, 1.0, 0.0, 2.0 * M_PI),
                    1.0, 1e-6);
    }
}

TEST(Lambert, SampleAgreesWithFAndPDF) {
    threadSamplerKind = SamplerKind::Pcg;
    for (vec3 wo : Viewers()) {
        for (uint i = 0; i < 10'000; ++i) {
            Sampler rng = StartPixelSample(uvec2(1u, 2u), i, 3u);
            const float uc = Get1D(rng);
            const BSDFSample s = Sample_f(Lobe(kAlbedo), wo, uc, Get2D(rng));
            ASSERT_GT(s.pdf, 0.0f);
            ASSERT_EQ(s.f, f(Lobe(kAlbedo), wo, s.wi));
            ASSERT_EQ(s.pdf, PDF(Lobe(kAlbedo), wo, s.wi));
            ASSERT_EQ(s.flags & ~Flags(Lobe(kAlbedo)), 0u);
            ASSERT_EQ(s.eta, 1.0f);
        }
    }
    threadSamplerKind = SamplerKind::Sobol;
}

TEST(Lambert, IsReciprocal) {
    std::mt19937 generator(5);
    const auto direction = [&] {
        return Direction(static_cast<float>(generator()) * 0x1p-31f - 1.0f,
                         static_cast<float>(generator() % 1000));
    };
    for (int i = 0; i < 10'000; ++i) {
        const vec3 a = direction();
        const vec3 b = direction();
        ASSERT_EQ(f(Lobe(kAlbedo), a, b), f(Lobe(kAlbedo), b, a));
    }
}

TEST(Lambert, FurnaceReturnsTheAlbedo) {
    for (vec3 wo : Viewers()) {
        // The albedo by quadrature of f cos over all wi ...
        for (int channel = 0; channel < 3; ++channel) {
            const auto integrand = [&](vec3 wi) {
                return static_cast<double>(f(Lobe(kAlbedo), wo, wi)[channel] * std::abs(wi.z));
            };
            EXPECT_NEAR(test::IntegrateOverSphere(integrand, -1.0, 0.0, 0.0, 2.0 * M_PI) +
                            test::IntegrateOverSphere(integrand, 0.0, 1.0, 0.0, 2.0 * M_PI),
                        static_cast<double>(kAlbedo[channel]), 1e-6);
        }
        // ... and by the estimator, which for this lobe has no variance.
        for (int i = 1; i < 64; ++i) {
            const vec2 u(static_cast<float>(i) / 64.0f, (static_cast<float>((i * 37) % 64) + 0.5f) / 64.0f);
            const BSDFSample s = Sample_f(Lobe(kAlbedo), wo, 0.5f, u);
            const vec3 weight = s.f * std::abs(s.wi.z) / s.pdf;
            EXPECT_NEAR(weight.x, kAlbedo.x, 1e-6f);
            EXPECT_NEAR(weight.y, kAlbedo.y, 1e-6f);
            EXPECT_NEAR(weight.z, kAlbedo.z, 1e-6f);
        }
    }
}

TEST(Lambert, NothingPassesThroughTheSurface) {
    const vec3 above = Direction(0.6f, 1.0f);
    const vec3 below = Direction(-0.6f, 1.0f);
    EXPECT_EQ(f(Lobe(kAlbedo), above, below), vec3(0.0f));
    EXPECT_EQ(PDF(Lobe(kAlbedo), above, below), 0.0f);
    EXPECT_LT(Sample_f(Lobe(kAlbedo), below, 0.5f, vec2(0.3f, 0.6f)).wi.z, 0.0f);
    EXPECT_TRUE(IsReflective(Flags(Lobe(kAlbedo))));
    EXPECT_TRUE(IsNonSpecular(Flags(Lobe(kAlbedo))));
    EXPECT_FALSE(IsTransmissive(Flags(Lobe(kAlbedo))));
    EXPECT_FALSE(IsSpecular(Flags(Lobe(kAlbedo))));
}

TEST(Lambert, BlackAndEdgeOnSurfacesGiveNoSample) {
    const DiffuseBxDF black = Lobe(vec3(0.0f));
    EXPECT_EQ(Flags(black), kBxDFNone);
    EXPECT_EQ(Sample_f(black, Direction(0.5f, 0.0f), 0.5f, vec2(0.3f, 0.6f)).pdf, 0.0f);
    EXPECT_EQ(PDF(black, Direction(0.5f, 0.0f), Direction(0.5f, 1.0f)), 0.0f);
    EXPECT_EQ(Sample_f(Lobe(kAlbedo), vec3(1.0f, 0.0f, 0.0f), 0.5f, vec2(0.3f, 0.6f)).pdf, 0.0f);
    // The rim of the disk has no density, and says so.
    EXPECT_EQ(Sample_f(Lobe(kAlbedo), Direction(0.5f, 0.0f), 0.5f, vec2(0.0f, 0.5f)).pdf, 0.0f);
}

}  // namespace
}  // namespace raygraph::shading::diffuse_test
