// Pearson's chi-squared test: does a sampler draw from the density it claims?
//
// The p-value is the chance that a right sampler does at least this badly. With seeds fixed a test's verdict
// never changes from run to run; a family of n tests at significance alpha compares each p-value with
// SidakLevel(alpha, n).
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

namespace raygraph::test {

// The regularized upper incomplete gamma function Q(a, x) = Gamma(a, x) / Gamma(a), for a > 0 and x >= 0, to
// about 1e-12 relative for a up to 1e6.
double RegularizedGammaQ(double a, double x);

// The chance that a chi-squared variable of so many degrees of freedom exceeds `statistic`.
double ChiSquarePValue(double statistic, double degreesOfFreedom);

// The level of each of `testCount` independent tests that together err with chance `alpha`.
double SidakLevel(double alpha, int testCount);

struct ChiSquareResult {
    double statistic = 0.0;
    int degreesOfFreedom = 0;
    double pValue = 1.0;
};

// Compares counts, cell by cell; both spans are of one size, expected counts are not negative. Cells
// expecting fewer than `minExpected` are merged, smallest first, until each merged cell expects that many. A
// hit where nothing at all is expected gives p = 0.
ChiSquareResult ChiSquareTest(std::span<const double> observed, std::span<const double> expected,
                              double minExpected = 5.0);

// The integral of a density on the unit sphere over zMin <= z <= zMax, phiMin <= phi <= phiMax, by adaptive
// Gauss quadrature in (z, phi), where solid angle is dz dphi. Good to about 1e-6 for densities without jumps
// inside.
double IntegrateOverSphere(const std::function<double(glm::vec3)>& density, double zMin, double zMax,
                           double phiMin, double phiMax);

struct DirectionTest {
    int sampleCount = 1'000'000;
    int zCount = 20;  // Cells of equal solid angle; even, so that z = 0 is an edge.
    int phiCount = 40;
    uint32_t seed = 1;
};

// Tests directions drawn from uniform (uc, u) against a density per solid angle. `sample` returns nothing
// when it fails; failures form one more cell, which expects what the density leaves below 1.
ChiSquareResult ChiSquareOfDirections(
    const std::function<std::optional<glm::vec3>(float uc, glm::vec2 u)>& sample,
    const std::function<double(glm::vec3)>& density, const DirectionTest& test = {});

}  // namespace raygraph::test
