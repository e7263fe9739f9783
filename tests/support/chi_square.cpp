#include "tests/support/chi_square.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "base/check.h"

namespace raygraph::test {

namespace {

constexpr double kTiny = 1e-300;
constexpr double kEpsilon = 1e-16;
// Failures that no density accounts for: directions on a rim, drawn when a 24-bit random number is 0.
constexpr double kRimShare = 0x1p-22;
constexpr int kMaxIterations = 1'000'000;

// x^a e^-x / Gamma(a), the factor before both expansions.
double GammaPrefactor(double a, double x) {
    return std::exp(a * std::log(x) - x - std::lgamma(a));
}

// P(a, x) by its power series: sum of x^n / (a (a+1) ... (a+n)). Converges fast for x < a + 1.
double LowerBySeries(double a, double x) {
    double term = 1.0 / a;
    double sum = term;
    for (int n = 1; n < kMaxIterations && term > sum * kEpsilon; ++n) {
        term *= x / (a + n);
        sum += term;
    }
    return sum * GammaPrefactor(a, x);
}

// Q(a, x) by its continued fraction, evaluated by Lentz's method. Converges fast for x > a + 1.
double UpperByContinuedFraction(double a, double x) {
    double b = x + 1.0 - a;
    double c = 1.0 / kTiny;
    double d = 1.0 / b;
    double fraction = d;
    for (int n = 1; n < kMaxIterations; ++n) {
        const double numerator = -n * (n - a);
        b += 2.0;
        d = numerator * d + b;
        if (std::abs(d) < kTiny) d = kTiny;
        c = b + numerator / c;
        if (std::abs(c) < kTiny) c = kTiny;
        d = 1.0 / d;
        const double factor = d * c;
        fraction *= factor;
        if (std::abs(factor - 1.0) < kEpsilon * 4.0) break;
    }
    return fraction * GammaPrefactor(a, x);
}

struct Rectangle {
    double zMin, zMax, phiMin, phiMax;
};

double GaussOverRectangle(const std::function<double(glm::vec3)>& density, const Rectangle& r) {
    // Five-point Gauss-Legendre rule on [-1, 1].
    constexpr std::array kNodes = {-0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683,
                                   0.906179845938664};
    constexpr std::array kWeights = {0.236926885056189, 0.478628670499366, 0.568888888888889,
                                     0.478628670499366, 0.236926885056189};
    const double zHalf = 0.5 * (r.zMax - r.zMin);
    const double phiHalf = 0.5 * (r.phiMax - r.phiMin);
    double sum = 0.0;
    for (size_t i = 0; i < kNodes.size(); ++i) {
        const double z = r.zMin + zHalf * (1.0 + kNodes[i]);
        const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
        for (size_t j = 0; j < kNodes.size(); ++j) {
            const double phi = r.phiMin + phiHalf * (1.0 + kNodes[j]);
            const glm::vec3 w(static_cast<float>(radius * std::cos(phi)),
                              static_cast<float>(radius * std::sin(phi)), static_cast<float>(z));
            sum += kWeights[i] * kWeights[j] * density(w);
        }
    }
    return sum * zHalf * phiHalf;
}

double IntegrateAdaptively(const std::function<double(glm::vec3)>& density, const Rectangle& r, double whole,
                           double tolerance, int depth) {
    const double z = 0.5 * (r.zMin + r.zMax);
    const double phi = 0.5 * (r.phiMin + r.phiMax);
    const std::array quarters = {Rectangle{r.zMin, z, r.phiMin, phi}, Rectangle{r.zMin, z, phi, r.phiMax},
                                 Rectangle{z, r.zMax, r.phiMin, phi}, Rectangle{z, r.zMax, phi, r.phiMax}};
    std::array<double, 4> parts{};
    for (size_t i = 0; i < 4; ++i) parts[i] = GaussOverRectangle(density, quarters[i]);
    const double sum = std::accumulate(parts.begin(), parts.end(), 0.0);
    if (depth == 0 || std::abs(sum - whole) <= tolerance) return sum;
    double refined = 0.0;
    for (size_t i = 0; i < 4; ++i)
        refined += IntegrateAdaptively(density, quarters[i], parts[i], tolerance * 0.25, depth - 1);
    return refined;
}

}  // namespace

double RegularizedGammaQ(double a, double x) {
    RG_CHECK_GT(a, 0.0);
    RG_CHECK_GE(x, 0.0);
    if (x == 0.0) return 1.0;
    return x < a + 1.0 ? 1.0 - LowerBySeries(a, x) : UpperByContinuedFraction(a, x);
}

double ChiSquarePValue(double statistic, double degreesOfFreedom) {
    return RegularizedGammaQ(0.5 * degreesOfFreedom, 0.5 * statistic);
}

double SidakLevel(double alpha, int testCount) {
    return -std::expm1(std::log1p(-alpha) / testCount);
}

ChiSquareResult ChiSquareTest(std::span<const double> observed, std::span<const double> expected,
                              double minExpected) {
    RG_CHECK_EQ(observed.size(), expected.size());
    std::vector<size_t> order(expected.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return expected[a] < expected[b]; });

    struct Cell {
        double observed = 0.0;
        double expected = 0.0;
    };
    std::vector<Cell> cells;
    Cell merged;
    for (size_t i : order) {
        RG_CHECK_GE(expected[i], 0.0);
        if (expected[i] == 0.0 && observed[i] > 0.0) return {std::numeric_limits<double>::infinity(), 0, 0.0};
        merged.observed += observed[i];
        merged.expected += expected[i];
        // Largest last: from the first large cell on, each stands alone.
        if (merged.expected >= minExpected) {
            cells.push_back(merged);
            merged = {};
        }
    }
    if (merged.expected > 0.0) cells.push_back(merged);

    ChiSquareResult result;
    for (const Cell& cell : cells) {
        const double difference = cell.observed - cell.expected;
        result.statistic += difference * difference / cell.expected;
    }
    result.degreesOfFreedom = static_cast<int>(cells.size()) - 1;
    if (result.degreesOfFreedom > 0)
        result.pValue = ChiSquarePValue(result.statistic, result.degreesOfFreedom);
    return result;
}

double IntegrateOverSphere(const std::function<double(glm::vec3)>& density, double zMin, double zMax,
                           double phiMin, double phiMax) {
    const Rectangle all{zMin, zMax, phiMin, phiMax};
    return IntegrateAdaptively(density, all, GaussOverRectangle(density, all), 1e-8, 10);
}

ChiSquareResult ChiSquareOfDirections(
    const std::function<std::optional<glm::vec3>(float uc, glm::vec2 u)>& sample,
    const std::function<double(glm::vec3)>& density, const DirectionTest& test) {
    RG_CHECK_EQ(test.zCount % 2, 0);
    const size_t cellCount = static_cast<size_t>(test.zCount) * static_cast<size_t>(test.phiCount);
    std::vector<double> observed(cellCount + 1, 0.0);
    std::vector<double> expected(cellCount + 1, 0.0);

    std::mt19937 generator(test.seed);
    const auto unit = [&] { return static_cast<float>(generator() >> 8) * 0x1p-24f; };
    for (int i = 0; i < test.sampleCount; ++i) {
        const float uc = unit();
        const float u0 = unit();
        const float u1 = unit();
        const std::optional<glm::vec3> w = sample(uc, glm::vec2(u0, u1));
        size_t cell = cellCount;
        if (w) {
            double turn =
                std::atan2(static_cast<double>(w->y), static_cast<double>(w->x)) * 0.5 / std::numbers::pi;
            if (turn < 0.0) turn += 1.0;
            const auto z = static_cast<int>((static_cast<double>(w->z) + 1.0) * 0.5 * test.zCount);
            const auto phi = static_cast<int>(turn * test.phiCount);
            cell =
                static_cast<size_t>(std::clamp(z, 0, test.zCount - 1)) * static_cast<size_t>(test.phiCount) +
                static_cast<size_t>(std::clamp(phi, 0, test.phiCount - 1));
        }
        observed[cell] += 1.0;
    }

    double total = 0.0;
    for (int z = 0; z < test.zCount; ++z) {
        for (int phi = 0; phi < test.phiCount; ++phi) {
            const double share =
                IntegrateOverSphere(density, 2.0 * z / test.zCount - 1.0, 2.0 * (z + 1) / test.zCount - 1.0,
                                    2.0 * std::numbers::pi * phi / test.phiCount,
                                    2.0 * std::numbers::pi * (phi + 1) / test.phiCount);
            total += share;
            expected[static_cast<size_t>(z * test.phiCount + phi)] = share * test.sampleCount;
        }
    }
    expected[cellCount] = std::max(1.0 - total, kRimShare) * test.sampleCount;
    return ChiSquareTest(observed, expected);
}

}  // namespace raygraph::test
