// Orders in which primitives are given to a builder that keeps them (lavapipe's). Threads: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/api.h"
#include "renderer/bvh/box.h"
#include "shaders/shared/choice.h"

namespace raygraph {

// clang-format off
#define RAYGRAPH_BUILD_ORDERS(X, Of) \
    X(Of, Morton, 0, "morton", "along a Morton curve through their centers, as GpuScene has them") \
    X(Of, Hilbert, 1, "hilbert", "along a Hilbert curve") \
    X(Of, Tree, 2, "tree", "from left to right in a tree by the surface area heuristic") \
    X(Of, Halves, 3, "halves", "of such a tree whose left parts have a power of two of the primitives")
// clang-format on
RAYGRAPH_CHOICE(BuildOrder, RAYGRAPH_BUILD_ORDERS)

// The primitives in that order.
RAYGRAPH_API std::vector<uint32_t> OrderBoxes(std::span<const Box> boxes, BuildOrder order);

}  // namespace raygraph
