#include "tests/shading/lobe_checks.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <numeric>

#include "core/frame.glsl"

namespace raygraph::shading {

namespace {

struct Rectangle {
    double sMin, sMax, phiMin, phiMax;
};

class Quadrature {
  public:
    Quadrature(const PolarGrid& grid, const Density& density)
        : m_frame(FrameFromZ(grid.axis)),
          m_isAboutZ(grid.axis.z == 1.0f),
          m_power(1 << grid.squarings),
          m_density(density) {}

    double Over(const Rectangle& r) const { return Refine(r, Gauss(r), 7); }

  private:
    // Five-point Gauss-Legendre rule in each of s and phi.
    double Gauss(const Rectangle& r) const {
        constexpr std::array kNodes = {-0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683,
                                       0.906179845938664};
        constexpr std::array kWeights = {0.236926885056189, 0.478628670499366, 0.568888888888889,
                                         0.478628670499366, 0.236926885056189};
        const double sHalf = 0.5 * (r.sMax - r.sMin);
        const double phiHalf = 0.5 * (r.phiMax - r.phiMin);
        std::array<double, 5> cosPhi{};
        std::array<double, 5> sinPhi{};
        for (size_t j = 0; j < 5; ++j) {
            const double phi = r.phiMin + phiHalf * (1.0 + kNodes[j]);
            cosPhi[j] = std::cos(phi);
            sinPhi[j] = std::sin(phi);
        }
        double sum = 0.0;
        for (size_t i = 0; i < 5; ++i) {
            const double s = r.sMin + sHalf * (1.0 + kNodes[i]);
            const double t = std::numbers::pi * std::pow(s, m_power);
            const double sinT = std::sin(t);
            const double measure = kWeights[i] * sinT * m_power * t / s;
            for (size_t j = 0; j < 5; ++j) {
                const vec3 w(static_cast<float>(sinT * cosPhi[j]), static_cast<float>(sinT * sinPhi[j]),
                             static_cast<float>(std::cos(t)));
                sum += measure * kWeights[j] * m_density(m_isAboutZ ? w : normalize(FromLocal(m_frame, w)));
            }
        }
        return sum * sHalf * phiHalf;
    }

    double Refine(const Rectangle& r, double whole, int depth) const {
        const double s = 0.5 * (r.sMin + r.sMax);
        const double phi = 0.5 * (r.phiMin + r.phiMax);
        const std::array quarters = {Rectangle{r.sMin, s, r.phiMin, phi}, Rectangle{r.sMin, s, phi, r.phiMax},
                                     Rectangle{s, r.sMax, r.phiMin, phi},
                                     Rectangle{s, r.sMax, phi, r.phiMax}};
        std::array<double, 4> parts{};
        for (size_t i = 0; i < 4; ++i) parts[i] = Gauss(quarters[i]);
        const double sum = std::accumulate(parts.begin(), parts.end(), 0.0);
        if (depth == 0 || std::abs(sum - whole) <= kTolerance) return sum;
        double refined = 0.0;
        for (size_t i = 0; i < 4; ++i) refined += Refine(quarters[i], parts[i], depth - 1);
        return refined;
    }

    static constexpr double kTolerance = 3e-8;
    Frame m_frame;
    bool m_isAboutZ;
    double m_power;
    const Density& m_density;
};

}  // namespace

PolarGrid PolarGrid::About(vec3 axis, float alpha) {
    // Squared twice, the ring at a fifth of the way is 0.005 from the axis.
    PolarGrid grid;
    grid.axis = axis;
    grid.squarings = alpha < 0.02f ? 2 : 1;
    return grid;
}

size_t PolarGrid::Cell(vec3 w) const {
    const vec3 local = axis.z == 1.0f ? w : ToLocal(FrameFromZ(axis), w);
    const float across = std::sqrt(local.x * local.x + local.y * local.y);
    float s = std::atan2(across, local.z) * kInvPi;
    for (int i = 0; i < squarings; ++i) s = std::sqrt(s);
    const float turn = std::atan2(local.y, local.x) * kInv2Pi;
    const int ring = std::min(static_cast<int>(s * static_cast<float>(ringCount)), ringCount - 1);
    const float sector = (turn < 0.0f ? turn + 1.0f : turn) * static_cast<float>(sectorCount);
    return static_cast<size_t>(ring * sectorCount + std::min(static_cast<int>(sector), sectorCount - 1));
}

std::vector<double> PolarGrid::Integrate(const Density& density) const {
    const Quadrature quadrature(*this, density);
    std::vector<double> cells;
    cells.reserve(CellCount());
    for (int ring = 0; ring < ringCount; ++ring) {
        for (int sector = 0; sector < sectorCount; ++sector) {
            cells.push_back(quadrature.Over({static_cast<double>(ring) / ringCount,
                                             static_cast<double>(ring + 1) / ringCount,
                                             2.0 * std::numbers::pi * sector / sectorCount,
                                             2.0 * std::numbers::pi * (sector + 1) / sectorCount}));
        }
    }
    return cells;
}

double PolarGrid::IntegrateSum(const Density& density) const {
    const std::vector<double> cells = Integrate(density);
    return std::accumulate(cells.begin(), cells.end(), 0.0);
}

}  // namespace raygraph::shading
