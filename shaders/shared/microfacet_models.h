// The models that make up a microfacet lobe, named once: the host sets the specialization constants below
// when a pipeline is created. bxdf/microfacet.glsl and bxdf/fresnel.glsl say what each is.
#ifndef RAYGRAPH_SHARED_MICROFACET_MODELS_H
#define RAYGRAPH_SHARED_MICROFACET_MODELS_H

#define RAYGRAPH_MICROFACET_DISTRIBUTIONS(X) \
    X(Ggx, 0)                                \
    X(Beckmann, 1)                           \
    X(Phong, 2)

// How microfacets hide each other.
//   Correlated: Smith's, by one height for both directions
//   Separable:  Smith's, each direction by itself
//   Shortcut:   Kelemen and Szirmay-Kalos, 1 / (L.H)^2 for all of G / (cos cos)
#define RAYGRAPH_MASKING_MODELS(X) \
    X(Correlated, 0)               \
    X(Separable, 1)                \
    X(Shortcut, 2)

#define RAYGRAPH_FRESNEL_MODELS(X) \
    X(Schlick, 0)                  \
    X(Dielectric, 1)               \
    X(Conductor, 2)                \
    X(Lazanyi, 3)

#ifdef __cplusplus

#include <cstdint>

namespace raygraph {

#define RAYGRAPH_DECLARE(name, value) name = value,
enum class MicrofacetModel : uint32_t { RAYGRAPH_MICROFACET_DISTRIBUTIONS(RAYGRAPH_DECLARE) };
enum class MaskingModel : uint32_t { RAYGRAPH_MASKING_MODELS(RAYGRAPH_DECLARE) };
enum class FresnelModel : uint32_t { RAYGRAPH_FRESNEL_MODELS(RAYGRAPH_DECLARE) };
#undef RAYGRAPH_DECLARE

// Below this alpha (roughness^2) a surface counts as smooth, and its lobe is a delta.
inline constexpr float kSmoothAlpha = 1e-3f;

inline constexpr uint32_t kDistributionConstantId = 1;
inline constexpr uint32_t kMaskingConstantId = 2;
inline constexpr uint32_t kFresnelConstantId = 3;

}  // namespace raygraph

#else

#define RAYGRAPH_DECLARE(name, value) const uint kDistribution##name = value;
RAYGRAPH_MICROFACET_DISTRIBUTIONS(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE
#define RAYGRAPH_DECLARE(name, value) const uint kMasking##name = value;
RAYGRAPH_MASKING_MODELS(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE
#define RAYGRAPH_DECLARE(name, value) const uint kFresnel##name = value;
RAYGRAPH_FRESNEL_MODELS(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE

const float kSmoothAlpha = 1e-3f;

const int kDistributionConstantId = 1;
const int kMaskingConstantId = 2;
const int kFresnelConstantId = 3;

#endif

#endif
