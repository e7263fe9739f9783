// The operators of core/tonemap.glsl, named once.
#ifndef RAYGRAPH_SHARED_TONEMAP_OPERATORS_H
#define RAYGRAPH_SHARED_TONEMAP_OPERATORS_H

#include "choice.h"

#define RAYGRAPH_TONEMAP_OPERATORS(X, Of) \
    X(Of, Linear, 0, "linear", "")        \
    X(Of, Srgb, 1, "srgb", "")            \
    X(Of, Reinhard, 2, "reinhard", "")    \
    X(Of, Aces, 3, "aces", "")            \
    X(Of, AgX, 4, "agx", "")              \
    X(Of, Neutral, 5, "neutral", "")

#ifdef __cplusplus
namespace raygraph {
RAYGRAPH_CHOICE(TonemapOperator, RAYGRAPH_TONEMAP_OPERATORS)
#endif

RAYGRAPH_CHOICE_CONSTANTS(Tonemap, RAYGRAPH_TONEMAP_OPERATORS)

#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif
