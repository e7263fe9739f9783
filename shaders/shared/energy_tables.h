// How much light rough GGX surfaces return by one bounce, as tables: one flat array of floats, made by
// shaders/bxdf/bake_energy_tables.cpp, read by bxdf/energy.glsl. Smith masking is height-correlated; Fresnel
// is Schlick's curve, so that each albedo is linear in F0 and F90. All entries are in [0, 1].
//
// Axes, evenly spaced: sqrt(cos theta) in [0, 1]; sqrt(alpha) in [0, 1]; |eta - 1| / (eta + 1) in [0, 1/2].
#ifndef RAYGRAPH_SHARED_ENERGY_TABLES_H
#define RAYGRAPH_SHARED_ENERGY_TABLES_H

#ifdef __cplusplus
#include <cstdint>
#define RAYGRAPH_CONSTANT inline constexpr
namespace raygraph {
using uint = uint32_t;
#else
#define RAYGRAPH_CONSTANT const
#endif

// Reflection, [alpha][cos]: A, B of the albedo F0 A + F90 B.
RAYGRAPH_CONSTANT uint kEnergyCosCount = 32u;
RAYGRAPH_CONSTANT uint kEnergyAlphaCount = 32u;
RAYGRAPH_CONSTANT uint kEnergyAlbedoOffset = 0u;
RAYGRAPH_CONSTANT uint kEnergyAlbedoStride = 2u;

// Means of reflection, [alpha]: cosine-weighted means over the hemisphere of A, B, A L and B L, where L is
// (1 - A - B) / (A + B); and the chance that light which met two facets meets a third, a fourth, ...
RAYGRAPH_CONSTANT uint kEnergyMeanOffset =
    kEnergyAlbedoOffset + kEnergyAlbedoStride * kEnergyCosCount * kEnergyAlphaCount;
RAYGRAPH_CONSTANT uint kEnergyMeanStride = 5u;

// Reflection and transmission together, [eta > 1, eta < 1][eta][alpha][cos]: the sums for (F0, F90) = (0, 0),
// (1, 0) and (0, 1). Total internal reflection is whole in each of them.
RAYGRAPH_CONSTANT uint kEnergyGlassCosCount = 16u;
RAYGRAPH_CONSTANT uint kEnergyGlassAlphaCount = 16u;
RAYGRAPH_CONSTANT uint kEnergyGlassEtaCount = 8u;
RAYGRAPH_CONSTANT uint kEnergyGlassStride = 3u;
RAYGRAPH_CONSTANT uint kEnergyGlassOffset = kEnergyMeanOffset + kEnergyMeanStride * kEnergyAlphaCount;

RAYGRAPH_CONSTANT uint kEnergyTableSize =
    kEnergyGlassOffset +
    kEnergyGlassStride * kEnergyGlassCosCount * kEnergyGlassAlphaCount * kEnergyGlassEtaCount * 2u;

#undef RAYGRAPH_CONSTANT
#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif
