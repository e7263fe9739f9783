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
    X(Of, Hilbert, 0, "hilbert", "along a Hilbert curve through their centers") \
    X(Of, Morton, 1, "morton", "along a Morton curve of 1024 steps an axis") \
    X(Of, Tree, 2, "tree", "from left to right in a tree by the surface area heuristic") \
    X(Of, Halves, 3, "halves", "of such a tree whose left parts have a power of two of the primitives")
// clang-format on
RAYGRAPH_CHOICE(BuildOrder, RAYGRAPH_BUILD_ORDERS)

inline constexpr BuildOrder kUsedOrder = BuildOrder::Hilbert;  // by GpuScene

// The primitives in that order.
RAYGRAPH_API std::vector<uint32_t> OrderBoxes(std::span<const Box> boxes, BuildOrder order);

}  // namespace raygraph
