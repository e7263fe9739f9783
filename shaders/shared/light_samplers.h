// The ways of choosing a light (lights/lights.glsl), named once.
//
//   Uniform: every light with power above 0 alike
//   Power:   by power
//   Bvh:     by what each may contribute to the point that is lit, through a tree over position and
//            orientation
#ifndef RAYGRAPH_SHARED_LIGHT_SAMPLERS_H
#define RAYGRAPH_SHARED_LIGHT_SAMPLERS_H

#include "choice.h"

#define RAYGRAPH_LIGHT_SAMPLERS(X, Of) \
    X(Of, Uniform, 0, "uniform", "")   \
    X(Of, Power, 1, "power", "")       \
    X(Of, Bvh, 2, "bvh", "by its possible contribution")

#ifdef __cplusplus
namespace raygraph {
RAYGRAPH_CHOICE(LightSampler, RAYGRAPH_LIGHT_SAMPLERS)
#endif

RAYGRAPH_CHOICE_CONSTANTS(LightSampler, RAYGRAPH_LIGHT_SAMPLERS)

#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif
