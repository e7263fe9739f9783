// The samplers of core/rng.glsl, named once.
#ifndef RAYGRAPH_SHARED_SAMPLER_KINDS_H
#define RAYGRAPH_SHARED_SAMPLER_KINDS_H

#include "choice.h"

#define RAYGRAPH_SAMPLER_KINDS(X, Of)          \
    X(Of, Sobol, 0, "sobol", "Owen-scrambled") \
    X(Of, Pcg, 1, "pcg", "")                   \
    X(Of, Tea, 2, "tea", "")

#ifdef __cplusplus
namespace raygraph {
RAYGRAPH_CHOICE(SamplerKind, RAYGRAPH_SAMPLER_KINDS)
#endif

RAYGRAPH_CHOICE_CONSTANTS(SamplerKind, RAYGRAPH_SAMPLER_KINDS)

#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif
