// Checks the contract of lobes; their tests run it over grids of parameters.
//
// Directions are cut into cells about an axis: the angle to it is pi s^(2^squarings), so that cells in (s,
// phi) can be as fine near the axis as a lobe is narrow there. About +z, not squared, the horizon is an edge.
// Densities are integrated over cells by adaptive Gauss quadrature to about 1e-6 of the whole.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <random>
#include <vector>

#include "bxdf/bxdf.glsl"
#include "tests/shading/random_values.h"
#include "tests/support/chi_square.h"

namespace raygraph::shading {

using Density = std::function<double(vec3)>;

struct PolarGrid {
    vec3 axis{0.0f, 0.0f, 1.0f};
    int squarings = 0;
    int ringCount = 20;
    int sectorCount = 40;

    // About a lobe of this alpha that points along `axis`.
    static PolarGrid About(vec3 axis, float alpha);
    [[nodiscard]] size_t CellCount() const { return static_cast<size_t>(ringCount * sectorCount); }
    [[nodiscard]] size_t Cell(vec3 w) const;
    // The integral over each cell.
    [[nodiscard]] std::vector<double> Integrate(const Density& density) const;
    [[nodiscard]] double IntegrateSum(const Density& density) const;
};

// Larger grids of parameters, for which RAYGRAPH_LONG_TESTS is set.
inline bool AreTestsLong() {
    return std::getenv("RAYGRAPH_LONG_TESTS") != nullptr;
}

// Directions that pass `counts`, cut by a grid on which the density there is smooth.
struct LobePart {
    PolarGrid grid;
    std::function<bool(vec3)> counts = [](vec3) { return true; };
};

// The direction of a sample; overloads for lobes that need not be evaluated for it.
template <class Lobe>
BSDFSample DirectionOf(const Lobe& lobe, vec3 wo, float uc, vec2 u) {
    return Sample_f(lobe, wo, uc, u);
}

// Many directions of Sample_f against PDF, over the parts, which do not overlap; all else is one more cell.
template <class Lobe>
test::ChiSquareResult ChiSquareOfLobe(const Lobe& lobe, vec3 wo, const std::vector<LobePart>& parts,
                                      uint32_t seed) {
    constexpr int kSampleCount = 300'000;
    std::vector<double> expected;
    double rest = 1.0;
    for (const LobePart& part : parts) {
        const auto pdf = [&](vec3 wi) {
            return part.counts(wi) ? static_cast<double>(PDF(lobe, wo, wi)) : 0.0;
        };
        for (const double share : part.grid.Integrate(pdf)) {
            rest -= share;
            // Quadrature may miss the sliver of a cell that the horizon cuts off. Such cells are merged.
            expected.push_back(std::max(share, 1e-8) * kSampleCount);
        }
    }
    // Failures that no density accounts for: rims drawn when a number is 0, and quadrature's error.
    expected.push_back(std::max(rest, 1e-6) * kSampleCount);

    Uniform uniform(seed);
    std::vector<double> observed(expected.size(), 0.0);
    for (int i = 0; i < kSampleCount; ++i) {
        const float uc = uniform();
        const BSDFSample s = DirectionOf(lobe, wo, uc, uniform.Pair());
        size_t cell = 0;
        bool isFound = false;
        for (size_t p = 0; s.pdf > 0.0f && p < parts.size() && !isFound; ++p) {
            isFound = parts[p].counts(s.wi);
            cell += isFound ? parts[p].grid.Cell(s.wi) : parts[p].grid.CellCount();
        }
        observed[isFound ? cell : expected.size() - 1] += 1.0;
    }
    return test::ChiSquareTest(observed, expected);
}

// Samples are what f and PDF say of their directions, and of the parts that Flags names.
template <class Lobe>
void ExpectSamplesAgree(const Lobe& lobe, vec3 wo, float tolerance, int count = 2'000) {
    Uniform uniform(7);
    float worstF = 0.0f;
    float worstPDF = 0.0f;
    for (int i = 0; i < count; ++i) {
        const float uc = uniform();
        const BSDFSample s = Sample_f(lobe, wo, uc, uniform.Pair());
        if (s.pdf == 0.0f) continue;
        ASSERT_TRUE(std::isfinite(s.pdf) && std::isfinite(s.f.x + s.f.y + s.f.z));
        ASSERT_GT(s.pdf, 0.0f);
        ASSERT_NEAR(length(s.wi), 1.0f, 1e-5f);
        ASSERT_EQ(s.flags & ~Flags(lobe), 0u);
        ASSERT_EQ(IsReflective(s.flags), SameHemisphere(wo, s.wi));
        worstPDF = std::max(worstPDF, std::abs(PDF(lobe, wo, s.wi) / s.pdf - 1.0f));
        const vec3 difference = abs(f(lobe, wo, s.wi) - s.f);
        worstF = std::max(worstF, MaxComponent(difference) / std::max(MaxComponent(s.f), 1e-20f));
    }
    EXPECT_LT(worstPDF, tolerance);
    EXPECT_LT(worstF, tolerance);
}

// The mean of f cos / pdf, scaled by eta^2, and its standard error.
struct Estimate {
    double mean = 0.0;
    double error = 0.0;
};
template <class Lobe>
Estimate EstimateAlbedo(const Lobe& lobe, vec3 wo, uint32_t seed, int count = 100'000) {
    Uniform uniform(seed);
    double sum = 0.0;
    double sum2 = 0.0;
    for (int i = 0; i < count; ++i) {
        const float uc = uniform();
        const BSDFSample s = Sample_f(lobe, wo, uc, uniform.Pair());
        if (s.pdf == 0.0f) continue;
        const double weight = static_cast<double>(s.f.x * std::abs(s.wi.z) / s.pdf * s.eta * s.eta);
        sum += weight;
        sum2 += weight * weight;
    }
    const double mean = sum / count;
    return {mean, std::sqrt(std::max(sum2 / count - mean * mean, 1e-12) / count)};
}

}  // namespace raygraph::shading
