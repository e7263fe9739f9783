// The meanings of a material's alpha (glTF 2.0, 3.9.4), in one list for all code.
//
//   Opaque: nothing
//   Mask:   where it is below the cutoff there is a hole
//   Blend:  the share of rays that the surface stops
#ifndef RAYGRAPH_SHARED_ALPHA_MODES_H
#define RAYGRAPH_SHARED_ALPHA_MODES_H

#include "choice.h"

// The notes are glTF's names.
#define RAYGRAPH_ALPHA_MODES(X, Of)      \
    X(Of, Opaque, 0, "opaque", "OPAQUE") \
    X(Of, Mask, 1, "mask", "MASK")       \
    X(Of, Blend, 2, "blend", "BLEND")

#ifdef __cplusplus
namespace raygraph::scene {
RAYGRAPH_CHOICE(AlphaMode, RAYGRAPH_ALPHA_MODES)
}  // namespace raygraph::scene
namespace raygraph {
#endif

RAYGRAPH_CHOICE_CONSTANTS(Alpha, RAYGRAPH_ALPHA_MODES)

#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif
