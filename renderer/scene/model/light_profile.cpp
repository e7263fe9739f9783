#include "renderer/scene/model/light_profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace raygraph::scene {
namespace {

// Holds integrals over [from, to] of sin x and of x sin x about `from`.
struct SineMoments {
    double zeroth, first;
};
SineMoments Moments(double from, double to) {
    return {std::cos(from) - std::cos(to), std::sin(to) - std::sin(from) - (to - from) * std::cos(to)};
}

}  // namespace

float LightProfile::MaxIntensity() const {
    return candela.empty() ? 0.0f : *std::ranges::max_element(candela);
}

double LightProfile::MeanIntensity() const {
    constexpr double kPi = std::numbers::pi;
    // The angle that begins at the axis of the planes, the polar one, and the turn about that axis. Of types
    // A and B the former is counted from the equator.
    const bool isPolarVertical = type != PhotometricType::B;
    const double pole = type == PhotometricType::C ? 0.0 : 0.5 * kPi;
    const std::vector<float>& polar = isPolarVertical ? vertical : horizontal;
    const std::vector<float>& turn = isPolarVertical ? horizontal : vertical;
    const auto at = [&](size_t p, size_t t) {
        const size_t v = isPolarVertical ? p : t, h = isPolarVertical ? t : p;
        return double{candela[h * vertical.size() + v]};
    };
    double sum = 0.0;
    for (size_t p = 0; p + 1 < polar.size(); ++p) {
        const double from = polar[p] + pole, to = polar[p + 1] + pole;
        const SineMoments moments = Moments(from, to);
        const auto ring = [&](size_t t) {
            const double slope = (at(p + 1, t) - at(p, t)) / (to - from);
            return at(p, t) * moments.zeroth + slope * moments.first;
        };
        if (turn.size() == 1) sum += 2.0 * kPi * ring(0);
        for (size_t t = 0; t + 1 < turn.size(); ++t)
            sum += 0.5 * (double{turn[t + 1]} - double{turn[t]}) * (ring(t) + ring(t + 1));
    }
    return sum / (4.0 * kPi);
}

}  // namespace raygraph::scene
