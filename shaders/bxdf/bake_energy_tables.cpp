// Writes the source file that holds the tables of shared/energy_tables.h:
//     raygraph_bake_energy_tables renderer/gpu_scene/energy_tables.cpp
// Takes about a minute, and writes the same file each time. Albedos are quadratures over visible facets in
// double precision, apart from the shading text that they are tested against; what happens after the first
// bounce is counted in random walks of bxdf/multiscatter_walk.glsl. Exit status 1: the file cannot be
// written.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <numbers>
#include <vector>

#include "bxdf/multiscatter_walk.glsl"
#include "shared/energy_tables.h"

namespace raygraph {
namespace {

// Facets per axis of the quadratures, and walks per alpha.
constexpr int kAlbedoPoints = 400;
constexpr int kGlassPoints = 160;
constexpr uint32_t kWalkCount = 400'000;

double Lambda(double alpha, double z) {
    return 0.5 * (std::sqrt(1.0 + alpha * alpha * std::max(0.0, 1.0 - z * z) / (z * z)) - 1.0);
}

double SchlickCurve(double cosine) {
    return std::pow(std::clamp(1.0 - cosine, 0.0, 1.0), 5.0);
}

// Of the light that meets a facet seen from a direction: cosine with the facet, and z and masking of where
// it is reflected and refracted to. z <= 0, or >= 0 for refraction: it does not get there.
struct FacetPath {
    double share;  // of the light; all shares add up to 1
    double cosI;
    double cosT;  // 0: total internal reflection
    double reflectedZ;
    double refractedZ;
};

// Calls visit(path) for points^2 of the facets visible from cosine mu. eta: n(beyond) / n(here).
template <typename Visit>
void ForEachVisibleFacet(double mu, double alpha, double eta, int points, Visit&& visit) {
    const double x = std::sqrt(std::max(0.0, 1.0 - mu * mu));
    const double scale = 1.0 / std::hypot(alpha * x, mu);
    const double sx = alpha * x * scale;
    const double sz = mu * scale;
    for (int i = 0; i < points; ++i) {
        // Squeezed towards both ends of the cap, where the integrands are steep
        const double v = (i + 0.5) / points;
        const double u = v * v * v * (10.0 + v * (6.0 * v - 15.0));
        const double z = 1.0 - u * (1.0 + sz);
        const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
        for (int j = 0; j < points; ++j) {
            // Half a turn: the other half mirrors it
            const double phi = std::numbers::pi * (j + 0.5) / points;
            const double hx = alpha * (r * std::cos(phi) + sx);
            const double hy = alpha * r * std::sin(phi);
            const double hz = std::max(0.0, z + sz);
            const double length = std::sqrt(hx * hx + hy * hy + hz * hz);
            if (length == 0.0) continue;
            const double mz = hz / length;
            FacetPath path{};
            path.share = 30.0 * v * v * (1.0 - v) * (1.0 - v) / (points * points);
            path.cosI = std::clamp((x * hx + mu * hz) / length, 0.0, 1.0);
            path.reflectedZ = 2.0 * path.cosI * mz - mu;
            const double cos2T = 1.0 - (1.0 - path.cosI * path.cosI) / (eta * eta);
            path.cosT = cos2T > 0.0 ? std::sqrt(cos2T) : 0.0;
            path.refractedZ = -mu / eta + (path.cosI / eta - path.cosT) * mz;
            visit(path);
        }
    }
}

struct Albedo {
    double a = 0.0;
    double b = 0.0;
};

Albedo ReflectionAlbedo(double mu, double alpha) {
    mu = std::max(mu, 1e-5);
    const double s = SchlickCurve(mu);
    if (alpha == 0.0) return {1.0 - s, s};
    Albedo albedo;
    const double lambdaO = Lambda(alpha, mu);
    ForEachVisibleFacet(mu, alpha, 1.0, kAlbedoPoints, [&](const FacetPath& path) {
        if (path.reflectedZ <= 0.0) return;
        const double weight = path.share * (1.0 + lambdaO) / (1.0 + lambdaO + Lambda(alpha, path.reflectedZ));
        const double schlick = SchlickCurve(path.cosI);
        albedo.a += weight * (1.0 - schlick);
        albedo.b += weight * schlick;
    });
    return albedo;
}

// Reflection and transmission for (F0, F90) = (0, 0), (1, 0), (0, 1).
std::array<double, kEnergyGlassStride> GlassEnergy(double mu, double alpha, double eta) {
    mu = std::max(mu, 1e-5);
    if (alpha == 0.0) return {1.0, 1.0, 1.0};
    std::array<double, kEnergyGlassStride> sums{};
    const double lambdaO = Lambda(alpha, mu);
    const auto masking = [&](double z) { return (1.0 + lambdaO) / (1.0 + lambdaO + Lambda(alpha, z)); };
    ForEachVisibleFacet(mu, alpha, eta, kGlassPoints, [&](const FacetPath& path) {
        const double reflected = path.reflectedZ > 0.0 ? path.share * masking(path.reflectedZ) : 0.0;
        if (path.cosT == 0.0) {
            for (double& sum : sums) sum += reflected;
            return;
        }
        const double refracted = path.refractedZ < 0.0 ? path.share * masking(path.refractedZ) : 0.0;
        const double s = SchlickCurve(eta < 1.0 ? path.cosT : path.cosI);
        sums[0] += refracted;
        sums[1] += (1.0 - s) * reflected + s * refracted;
        sums[2] += s * reflected + (1.0 - s) * refracted;
    });
    return sums;
}

// The chance q of one more facet after the second, such that facets of reflectance 1/2 return as much light
// in all later bounces as the walk does: sum over n >= 2 of e(n) F^(n - 1) = (1 - e(1)) F (1 - q) / (1 - q
// F).
double ContinuationChance(double alpha) {
    using namespace shading;
    if (alpha == 0.0) return 0.0;
    WalkSurface surface;
    surface.alpha = vec2(static_cast<float>(alpha));
    surface.kind = kWalkAbsorbs;
    surface.fresnel.f0 = surface.fresnel.f90 = vec3(0.5f);
    surface.fresnel.eta = 1.0f;
    double count = 0.0;
    double sum = 0.0;
    for (uint32_t i = 0; i < kWalkCount; ++i) {
        WalkRng rng = StartWalkRng(i + 0x40000000u);
        const vec3 wo = SampleCosineHemisphere(WalkGet2D(rng));
        if (wo.z <= 0.0f) continue;
        const WalkSample s = SampleWalk(surface, wo, i);
        if (s.bounceCount < 2) continue;
        count += 1.0;
        sum += 2.0 * static_cast<double>(s.weight.x);
    }
    const double share = count > 0.0 ? sum / count : 0.5;
    return std::clamp((1.0 - 2.0 * share) / (1.0 - share), 0.0, 1.0);
}

double Square(double x) {
    return x * x;
}

// The mean over the hemisphere, weighted by the cosine, of each quantity as the device interpolates the
// albedos: linearly in sqrt(cos).
std::array<double, 4> Means(const std::vector<Albedo>& row) {
    constexpr int kPerCell = 32;
    const int cells = static_cast<int>(row.size()) - 1;
    std::array<double, 4> sums{};
    for (int i = 0; i < cells * kPerCell; ++i) {
        const double x = (i + 0.5) / kPerCell;
        const auto cell = static_cast<size_t>(x);
        const double t = x - static_cast<double>(cell);
        const double a = row[cell].a * (1.0 - t) + row[cell + 1].a * t;
        const double b = row[cell].b * (1.0 - t) + row[cell + 1].b * t;
        const double loss = (1.0 - a - b) / (a + b);
        // 2 mu dmu with mu = (x / cells)^2
        const double weight = 4.0 * std::pow(x / cells, 3.0) / (cells * kPerCell);
        sums[0] += a * weight;
        sums[1] += b * weight;
        sums[2] += a * loss * weight;
        sums[3] += b * loss * weight;
    }
    return sums;
}

std::vector<double> BakeTables() {
    std::vector<double> table;
    std::vector<double> means;
    for (uint alphaIndex = 0; alphaIndex < kEnergyAlphaCount; ++alphaIndex) {
        const double alpha = Square(alphaIndex / (kEnergyAlphaCount - 1.0));
        std::vector<Albedo> row;
        for (uint i = 0; i < kEnergyCosCount; ++i) {
            row.push_back(ReflectionAlbedo(Square(i / (kEnergyCosCount - 1.0)), alpha));
            table.insert(table.end(), {row.back().a, row.back().b});
        }
        const std::array<double, 4> mean = Means(row);
        means.insert(means.end(), mean.begin(), mean.end());
        means.push_back(ContinuationChance(alpha));
    }
    table.insert(table.end(), means.begin(), means.end());
    for (const bool isDenser : {true, false}) {
        for (uint etaIndex = 0; etaIndex < kEnergyGlassEtaCount; ++etaIndex) {
            const double x = 0.5 * etaIndex / (kEnergyGlassEtaCount - 1.0);
            const double eta = isDenser ? (1.0 + x) / (1.0 - x) : (1.0 - x) / (1.0 + x);
            for (uint alphaIndex = 0; alphaIndex < kEnergyGlassAlphaCount; ++alphaIndex) {
                const double alpha = Square(alphaIndex / (kEnergyGlassAlphaCount - 1.0));
                for (uint i = 0; i < kEnergyGlassCosCount; ++i) {
                    const auto energy = GlassEnergy(Square(i / (kEnergyGlassCosCount - 1.0)), alpha, eta);
                    table.insert(table.end(), energy.begin(), energy.end());
                }
            }
        }
    }
    return table;
}

void Write(std::ostream& file, const std::vector<double>& table) {
    file << "// Data table: energy of rough surfaces, made by raygraph_bake_energy_tables. In units of 1 / "
            "65535.\n"
            "#include \"renderer/gpu_scene/energy_tables.h\"\n\n#include <array>\n#include <cstdint>\n\n"
            "#include \"shaders/shared/energy_tables.h\"\n\nnamespace raygraph {\nnamespace {\n\n"
            "// clang-format off\nconstexpr std::array<uint16_t, kEnergyTableSize> kEntries = {\n";
    constexpr size_t kPerLine = 18;
    for (size_t i = 0; i < table.size(); ++i) {
        file << std::lround(std::clamp(table[i], 0.0, 1.0) * 65535.0)
             << ((i + 1) % kPerLine == 0 || i + 1 == table.size() ? ",\n" : ",");
    }
    file << "};\n// clang-format on\n\n"
            "std::array<float, kEnergyTableSize> ToFloats() {\n"
            "    std::array<float, kEnergyTableSize> floats{};\n"
            "    for (size_t i = 0; i < floats.size(); ++i) floats[i] = static_cast<float>(kEntries[i]) / "
            "65535.0f;\n"
            "    return floats;\n}\n\n}  // namespace\n\n"
            "std::span<const float> EnergyTables() {\n"
            "    static const std::array<float, kEnergyTableSize> floats = ToFloats();\n"
            "    return floats;\n}\n\n}  // namespace raygraph\n";
}

}  // namespace
}  // namespace raygraph

int main(int argc, char** argv) {
    if (argc != 2) return 1;
    std::ofstream file(argv[1]);
    if (!file) return 1;
    raygraph::Write(file, raygraph::BakeTables());
    file.close();
    return file ? 0 : 1;
}
