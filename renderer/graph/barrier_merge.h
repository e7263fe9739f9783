// Merges the barriers of the subresources of a texture: equal ones of neighboring levels and layers become
// one. Threads: pure functions of their arguments.
#pragma once

#include <cstddef>
#include <vector>

#include "renderer/graph/plan.h"

namespace raygraph {

// Adds the barrier of one subresource if it is needed. The subresources of a resource must be added layer by
// layer, and level by level within each; the barriers from `first` on are of that resource.
void AddBarrier(std::vector<PlannedBarrier>& barriers, size_t first, const PlannedBarrier& barrier);
// Merges the layers. Must be called once all subresources have been added.
void MergeLayers(std::vector<PlannedBarrier>& barriers, size_t first);

}  // namespace raygraph
