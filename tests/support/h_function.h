// Computes the reflection of a half space of an isotropically scattering medium.
#pragma once

#include <cmath>
#include <vector>

namespace raygraph::testing {

// Chandrasekhar's H function of isotropic scattering (Radiative Transfer, 1950, section 37), by iteration of
//     1 / H(mu) = sqrt(1 - albedo) + albedo / 2 integral_0^1 x H(x) / (mu + x) dx.
class HFunction {
  public:
    explicit HFunction(double albedo) : m_albedo(albedo), m_values(kCount, 1.0) {
        for (int round = 0; round < 400; ++round) {
            std::vector<double> next(kCount);
            for (int i = 0; i < kCount; ++i) next[i] = At((i + 0.5) / kCount);
            m_values = next;
        }
    }
    double At(double mu) const {
        double sum = 0.0;
        for (int i = 0; i < kCount; ++i) {
            const double x = (i + 0.5) / kCount;
            sum += x * m_values[i] / (mu + x);
        }
        return 1.0 / (std::sqrt(1.0 - m_albedo) + 0.5 * m_albedo * sum / kCount);
    }
    // Returns the fraction of uniform light that is reflected towards mu.
    double Reflected(double mu) const { return 1.0 - At(mu) * std::sqrt(1.0 - m_albedo); }
    // Returns the fraction of uniform light that is reflected in all directions.
    double ReflectedToAll() const {
        double sum = 0.0;
        for (int i = 0; i < kCount; ++i) sum += 2.0 * (i + 0.5) / kCount * Reflected((i + 0.5) / kCount);
        return sum / kCount;
    }

  private:
    static constexpr int kCount = 256;
    double m_albedo;
    std::vector<double> m_values;
};

}  // namespace raygraph::testing
