// The models that make up a microfacet lobe, named once. bxdf/microfacet.glsl and bxdf/fresnel.glsl say what
// each is.
#ifndef RAYGRAPH_SHARED_MICROFACET_MODELS_H
#define RAYGRAPH_SHARED_MICROFACET_MODELS_H

#include "choice.h"

#define RAYGRAPH_MICROFACET_DISTRIBUTIONS(X, Of) \
    X(Of, Ggx, 0, "ggx", "")                     \
    X(Of, Beckmann, 1, "beckmann", "")           \
    X(Of, Phong, 2, "phong", "")

// Masking and shadowing of microfacets.
//   Correlated: Smith's, by one height for both directions
//   Separable:  Smith's, each direction by itself
//   Shortcut:   Kelemen and Szirmay-Kalos, 1 / (L.H)^2 for all of G / (cos cos)
#define RAYGRAPH_MASKING_MODELS(X, Of)          \
    X(Of, Correlated, 0, "correlated", "Smith") \
    X(Of, Separable, 1, "separable", "")        \
    X(Of, Shortcut, 2, "shortcut", "")

#define RAYGRAPH_FRESNEL_MODELS(X, Of)     \
    X(Of, Schlick, 0, "schlick", "")       \
    X(Of, Dielectric, 1, "dielectric", "") \
    X(Of, Conductor, 2, "conductor", "")   \
    X(Of, Lazanyi, 3, "lazanyi", "")

#ifdef __cplusplus
namespace raygraph {
RAYGRAPH_CHOICE(MicrofacetModel, RAYGRAPH_MICROFACET_DISTRIBUTIONS)
RAYGRAPH_CHOICE(MaskingModel, RAYGRAPH_MASKING_MODELS)
RAYGRAPH_CHOICE(FresnelModel, RAYGRAPH_FRESNEL_MODELS)

// Below this alpha (roughness^2) a surface counts as smooth, and its lobe is a delta.
inline constexpr float kSmoothAlpha = 1e-3f;
#else
const float kSmoothAlpha = 1e-3f;
#endif

RAYGRAPH_CHOICE_CONSTANTS(Distribution, RAYGRAPH_MICROFACET_DISTRIBUTIONS)
RAYGRAPH_CHOICE_CONSTANTS(Masking, RAYGRAPH_MASKING_MODELS)
RAYGRAPH_CHOICE_CONSTANTS(Fresnel, RAYGRAPH_FRESNEL_MODELS)

#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif
