// Writes the file of the tables of shared/energy_tables.h:
//     raygraph_bake_energy_tables renderer/gpu_scene/materials/energy_tables.cpp.bin
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

// These are the facets per axis of the quadratures, and the walks per entry.
constexpr int kAlbedoPoints = 300;
constexpr int kGlassPoints = 120;
constexpr uint32_t kReflectionWalks = 40'000;
constexpr uint32_t kMeanWalks = 400'000;
constexpr uint32_t kGlassWalks = 40'000;

double Lambda(double alpha, double z) {
    return 0.5 * (std::sqrt(1.0 + alpha * alpha * std::max(0.0, 1.0 - z * z) / (z * z)) - 1.0);
}

double SchlickCurve(double cosine) {
    return std::pow(std::clamp(1.0 - cosine, 0.0, 1.0), 5.0);
}

// Describes a part of the light that comes from one direction and meets a facet: the cosine with the facet,
// and the z and the masking of the directions of reflection and refraction. z <= 0, or >= 0 for refraction:
// it does not get there.
struct FacetPath {
    double share;  // share of the light; all shares add up to 1
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
            // Half a turn is enough: the other half mirrors it
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

double Square(double x) {
    return x * x;
}

// Describes one bounce of glass: transmission (1 - F0) c + (1 - F90) d, reflection k + F0 a + F90 b.
struct GlassBounce {
    double c = 0.0;
    double d = 0.0;
    double k = 0.0;
    double a = 0.0;
    double b = 0.0;
};

GlassBounce OneBounceOfGlass(double mu, double alpha, double eta) {
    GlassBounce bounce;
    if (alpha == 0.0) {
        const double cos2T = 1.0 - (1.0 - mu * mu) / (eta * eta);
        const double s = SchlickCurve(eta > 1.0 ? mu : std::sqrt(std::max(cos2T, 0.0)));
        if (cos2T <= 0.0) return {.k = 1.0};
        return {.c = 1.0 - s, .d = s, .a = 1.0 - s, .b = s};
    }
    const double lambdaO = Lambda(alpha, mu);
    const auto masking = [&](double z) { return (1.0 + lambdaO) / (1.0 + lambdaO + Lambda(alpha, z)); };
    ForEachVisibleFacet(mu, alpha, eta, kGlassPoints, [&](const FacetPath& path) {
        const double reflected = path.reflectedZ > 0.0 ? path.share * masking(path.reflectedZ) : 0.0;
        if (path.cosT == 0.0) {
            bounce.k += reflected;
            return;
        }
        const double refracted = path.refractedZ < 0.0 ? path.share * masking(path.refractedZ) : 0.0;
        const double s = SchlickCurve(eta < 1.0 ? path.cosT : path.cosI);
        bounce.c += (1.0 - s) * refracted;
        bounce.d += s * refracted;
        bounce.a += (1.0 - s) * reflected;
        bounce.b += s * reflected;
    });
    return bounce;
}

shading::vec3 ViewAt(double mu) {
    return {static_cast<float>(std::sqrt(std::max(0.0, 1.0 - mu * mu))), 0.0f, static_cast<float>(mu)};
}

shading::WalkSurface Surface(double alpha, uint kind, float f0, float f90, double eta) {
    shading::WalkSurface surface{};
    surface.alpha = shading::vec2(static_cast<float>(alpha));
    surface.kind = kind;
    surface.eta = static_cast<float>(eta);
    surface.fresnel.f0 = shading::vec3(f0);
    surface.fresnel.f90 = shading::vec3(f90);
    surface.fresnel.exactF90 = shading::vec3(1.0f);
    surface.fresnel.isMetal = false;
    return surface;
}

// Holds Schlick's curve at the facets of one walk.
struct WalkedFacets {
    uint32_t count = 0;
    double first = 0.0;
    double second = 0.0;
    double later = 0.0;  // sum over the rest
};

WalkedFacets WalkFacets(const shading::WalkSurface& white, shading::vec3 wo, uint32_t seed) {
    WalkedFacets facets;
    shading::WalkRng rng = shading::StartWalkRng(seed);
    shading::WalkRay ray = shading::StartWalkRay(wo);
    while (facets.count < shading::kWalkBounceLimit &&
           shading::AdvanceToNextFacet(ray, white.alpha, shading::WalkGet1D(rng))) {
        const shading::vec3 before = ray.view;
        shading::ScatterAtFacet(ray, white, rng, false);
        // A mirror moves the direction by twice the cosine
        const double curve = SchlickCurve(0.5 * static_cast<double>(shading::length(before - ray.view)));
        (facets.count == 0 ? facets.first : facets.count == 1 ? facets.second : facets.later) += curve;
        ++facets.count;
    }
    return facets;
}

// Holds the fate of light of one roughness and direction after its first facet.
struct LaterFacets {
    double curveMean = 0.0;         // mean of (s1 + s2) / 2, where s is Schlick's curve
    double curveProduct = 0.0;      // mean of s1 s2
    double continuation = 0.0;      // q
    double higherOrderCurve = 0.0;  // mean of s from the third facet on
};

// q is such that facets of reflectance F = 1/2 return as much in all bounces from the second on as the walk
// does: sum over n >= 2 of e(n) F^(n - 1) = (1 - e(1)) F (1 - q) / (1 - q F), e(n) leaving after n.
template <typename View>
LaterFacets WalkLaterFacets(double alpha, uint32_t walkCount, View&& view) {
    LaterFacets result;
    if (alpha == 0.0) return result;
    const shading::WalkSurface white = Surface(alpha, shading::kWalkAbsorbs, 1.0f, 1.0f, 1.0);
    double count = 0.0;
    double dimmed = 0.0;
    double higherOrderCount = 0.0;
    for (uint32_t i = 0; i < walkCount; ++i) {
        const shading::vec3 wo = view(i);
        if (wo.z <= 0.0f) continue;
        const WalkedFacets facets = WalkFacets(white, wo, i);
        if (facets.count < 2) continue;
        count += 1.0;
        result.curveMean += 0.5 * (facets.first + facets.second);
        result.curveProduct += facets.first * facets.second;
        dimmed += std::exp2(1.0 - facets.count);
        higherOrderCount += facets.count - 2;
        result.higherOrderCurve += facets.later;
    }
    if (count == 0.0) return result;
    result.curveMean /= count;
    result.curveProduct /= count;
    const double share = dimmed / count;
    result.continuation = std::clamp((1.0 - 2.0 * share) / (1.0 - share), 0.0, 1.0);
    if (higherOrderCount > 0.0) result.higherOrderCurve /= higherOrderCount;
    return result;
}

// An entry of the reflection tables has five numbers.
constexpr size_t kReflectionSize = 5;

std::array<double, kReflectionSize> Reflection(double mu, double alpha) {
    const Albedo albedo = ReflectionAlbedo(mu, alpha);
    const shading::vec3 wo = ViewAt(std::max(mu, 1e-5));
    const LaterFacets later = WalkLaterFacets(alpha, kReflectionWalks, [&](uint32_t) { return wo; });
    // The walks say how the curve is distributed, the quadrature how much light there is
    const double second = std::max(0.0, 1.0 - albedo.a - albedo.b);
    return {albedo.a, albedo.b, later.curveMean * second, later.curveProduct * second, later.continuation};
}

using Entry = std::array<double, kEnergyEntrySize>;

// Returns one entry of the tables of glass.
Entry Glass(double mu, double alpha, double eta) {
    mu = std::max(mu, 1e-5);
    const GlassBounce bounce = OneBounceOfGlass(mu, alpha, eta);
    const double f0 = Square((eta - 1.0) / (eta + 1.0));
    const float f90 = shading::DielectricF90(static_cast<float>(eta));
    double reflected = bounce.k + f0 * bounce.a + static_cast<double>(f90) * bounce.b;
    if (alpha > 0.0) {
        const shading::WalkSurface surface =
            Surface(alpha, shading::kWalkRefracts, static_cast<float>(f0), f90, eta);
        double count = 0.0;
        for (uint32_t i = 0; i < kGlassWalks; ++i)
            count += shading::SampleWalk(surface, ViewAt(mu), i).wi.z > 0.0f ? 1.0 : 0.0;
        reflected = count / kGlassWalks;
    }
    if (eta > 1.0) return {bounce.c, bounce.d, reflected};
    return {bounce.c, bounce.d, reflected, 0.0, bounce.k, bounce.a, bounce.b};
}

// Returns the mean over the hemisphere, weighted by the cosine, of what the device interpolates linearly in
// sqrt(cos).
template <size_t kSize>
std::array<double, kSize> Means(const std::vector<std::array<double, kSize>>& row) {
    constexpr int kPerCell = 32;
    const int cells = static_cast<int>(row.size()) - 1;
    std::array<double, kSize> sums{};
    for (int i = 0; i < cells * kPerCell; ++i) {
        const double x = (i + 0.5) / kPerCell;
        const auto cell = static_cast<size_t>(x);
        const double t = x - static_cast<double>(cell);
        // This is 2 mu dmu with mu = (x / cells)^2
        const double weight = 4.0 * std::pow(x / cells, 3.0) / (cells * kPerCell);
        for (size_t j = 0; j < kSize; ++j)
            sums[j] += weight * (row[cell][j] * (1.0 - t) + row[cell + 1][j] * t);
    }
    return sums;
}

void AppendGlass(std::vector<Entry>& table, bool isEntering) {
    for (uint etaIndex = 0; etaIndex < kEnergyGlassEtaCount; ++etaIndex) {
        // Matched media have no facets to speak of: take those that are nearly so
        const double x = std::max(0.5 * Square(etaIndex / (kEnergyGlassEtaCount - 1.0)), 1e-4);
        const double eta = isEntering ? (1.0 + x) / (1.0 - x) : (1.0 - x) / (1.0 + x);
        for (uint alphaIndex = 0; alphaIndex < kEnergyGlassAlphaCount; ++alphaIndex) {
            const double alpha = Square(alphaIndex / (kEnergyGlassAlphaCount - 1.0));
            for (uint i = 0; i < kEnergyGlassCosCount; ++i) {
                table.push_back(Glass(Square(i / (kEnergyGlassCosCount - 1.0)), alpha, eta));
            }
        }
    }
}

// Returns the five numbers, and what may follow them.
Entry ReflectionEntry(const std::array<double, kReflectionSize>& numbers, double sixth = 0.0) {
    Entry entry{};
    std::copy(numbers.begin(), numbers.end(), entry.begin());
    entry[kReflectionSize] = sixth;
    return entry;
}

// Returns the exponent of Lambda of sheen, as bxdf/sheen.glsl has it.
double SheenFit(double alpha, double x) {
    const double t = Square(1.0 - alpha);
    return std::lerp(21.5473, 25.3245, t) /
               (1.0 + std::lerp(3.82987, 3.32435, t) * std::pow(x, std::lerp(0.19823, 0.16801, t))) +
           std::lerp(-1.97760, -1.27393, t) * x + std::lerp(-4.32054, -4.85967, t);
}

double SheenLambda(double alpha, double z) {
    return std::exp(z < 0.5 ? SheenFit(alpha, z) : 2.0 * SheenFit(alpha, 0.5) - SheenFit(alpha, 1.0 - z));
}

// Returns the albedo of white sheen from cosine mu, with f times cap(cosine of the light).
template <typename Cap>
double SheenAlbedo(double mu, double alpha, const Cap& cap) {
    constexpr int kHeights = 1000, kAngles = 400;
    const double x = std::sqrt(1.0 - mu * mu), exponent = 1.0 / alpha, lambda = SheenLambda(alpha, mu);
    double sum = 0.0;
    for (int i = 0; i < kHeights; ++i) {
        const double v = (i + 0.5) / kHeights, z = v * v, r = std::sqrt(1.0 - z * z);
        const double scale =
            2.0 * v * (2.0 + exponent) * cap(z) / (4.0 * mu * (1.0 + lambda + SheenLambda(alpha, z)));
        for (int j = 0; j < kAngles; ++j) {
            const double phi = std::numbers::pi * (j + 0.5) / kAngles;
            const double hx = x + r * std::cos(phi), hy = r * std::sin(phi), hz = mu + z;
            const double cos2 = hz * hz / (hx * hx + hy * hy + hz * hz);
            sum += scale * std::pow(std::max(1.0 - cos2, 0.0), 0.5 * exponent);
        }
    }
    return sum / (kHeights * kAngles);
}

void AppendSheen(std::vector<Entry>& table) {
    std::vector<Entry> means;
    for (uint alphaIndex = 0; alphaIndex < kEnergyAlphaCount; ++alphaIndex) {
        const double alpha = std::max(Square(alphaIndex / (kEnergyAlphaCount - 1.0)), double{kMinSheenAlpha});
        const auto cosineOf = [](uint i) { return std::max(Square(i / (kEnergyCosCount - 1.0)), 1e-4); };
        std::vector<double> caps;
        for (uint i = 0; i < kEnergyCosCount; ++i)
            caps.push_back(1.0 / std::max(SheenAlbedo(cosineOf(i), alpha, [](double) { return 1.0; }), 1.0));
        // The interpolation is the device's.
        const auto capAt = [&](double z) {
            const double place = std::sqrt(z) * (kEnergyCosCount - 1.0);
            const auto first = std::min(static_cast<size_t>(place), caps.size() - 2);
            return std::lerp(caps[first], caps[first + 1], place - static_cast<double>(first));
        };
        std::vector<std::array<double, 1>> row;
        for (uint i = 0; i < kEnergyCosCount; ++i) {
            row.push_back(
                {SheenAlbedo(cosineOf(i), alpha, [&](double z) { return std::min(caps[i], capAt(z)); })});
            table.push_back({row.back()[0], caps[i]});
        }
        means.push_back({Means(row)[0]});
    }
    table.insert(table.end(), means.begin(), means.end());
}

std::vector<Entry> BakeTables() {
    std::vector<Entry> table;
    std::vector<Entry> means;
    for (uint alphaIndex = 0; alphaIndex < kEnergyAlphaCount; ++alphaIndex) {
        const double alpha = Square(alphaIndex / (kEnergyAlphaCount - 1.0));
        std::vector<std::array<double, kReflectionSize>> row;
        for (uint i = 0; i < kEnergyCosCount; ++i) {
            row.push_back(Reflection(Square(i / (kEnergyCosCount - 1.0)), alpha));
            table.push_back(ReflectionEntry(row.back()));
        }
        auto mean = Means(row);
        const LaterFacets later = WalkLaterFacets(alpha, kMeanWalks, [](uint32_t i) {
            shading::WalkRng rng = shading::StartWalkRng(i + 0x40000000u);
            return shading::SampleCosineHemisphere(shading::WalkGet2D(rng));
        });
        mean.back() = later.continuation;
        means.push_back(ReflectionEntry(mean, later.higherOrderCurve));
    }
    table.insert(table.end(), means.begin(), means.end());
    AppendGlass(table, true);
    AppendGlass(table, false);
    AppendSheen(table);
    return table;
}

void Write(std::ostream& file, const std::vector<Entry>& table) {
    for (const Entry& entry : table) {
        for (const double number : entry) {
            const auto units = static_cast<uint16_t>(std::lround(std::clamp(number, 0.0, 1.0) * 65535.0));
            file.put(static_cast<char>(units & 0xff)).put(static_cast<char>(units >> 8));
        }
    }
}

}  // namespace
}  // namespace raygraph

int main(int argc, char** argv) {
    if (argc != 2) return 1;
    std::ofstream file(argv[1], std::ios::binary);
    if (!file) return 1;
    raygraph::Write(file, raygraph::BakeTables());
    file.close();
    return file ? 0 : 1;
}
