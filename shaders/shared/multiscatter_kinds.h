// Treatment of multiple scattering between the facets of a rough surface, named once.
//
//   Off:  it is lost
//   Lut:  single scattering, scaled up by tables to what the walk returns
//   Walk: a random walk among the facets, the reference from which the tables are computed
#ifndef RAYGRAPH_SHARED_MULTISCATTER_KINDS_H
#define RAYGRAPH_SHARED_MULTISCATTER_KINDS_H

#include "choice.h"

#define RAYGRAPH_MULTISCATTER_KINDS(X, Of)        \
    X(Of, Off, 0, "off", "lost")                  \
    X(Of, Lut, 1, "lut", "compensated by tables") \
    X(Of, Walk, 2, "walk", "simulated")

#ifdef __cplusplus
namespace raygraph {
RAYGRAPH_CHOICE(MultiscatterKind, RAYGRAPH_MULTISCATTER_KINDS)
#endif

RAYGRAPH_CHOICE_CONSTANTS(MultiscatterKind, RAYGRAPH_MULTISCATTER_KINDS)

#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif
