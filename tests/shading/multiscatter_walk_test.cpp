#include "bxdf/multiscatter_walk.glsl"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

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
    constexpr uint kCount = 200'000;
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
    constexpr uint kCount = 200'000;
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
