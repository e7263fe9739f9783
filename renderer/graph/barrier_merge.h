// Merges the barriers of the subresources of a texture: equal ones of neighboring levels and layers become
// one. Pure.
#pragma once

#include <cstddef>
#include <vector>

#include "renderer/graph/plan.h"

namespace raygraph {

// Adds the barrier of one subresource, if it is needed. The subresources of a resource come layer by layer,
// each level by level; the barriers from `first` on are of that resource.
void AddBarrier(std::vector<PlannedBarrier>& barriers, size_t first, const PlannedBarrier& barrier);
// Merges the layers, when all subresources have been added.
void MergeLayers(std::vector<PlannedBarrier>& barriers, size_t first);

}  // namespace raygraph
