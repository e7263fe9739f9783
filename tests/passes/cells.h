// Square cells of 1 m side by side, seen from above: where test scenes place what they tell apart.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph::testing {

// What hit ids have for pixels without a hit.
inline constexpr uint32_t kMiss = 0xFFFFFFFFu;

// Of a square of `side` cells a side, from the origin on.
inline glm::vec3 CellCenter(uint32_t cell, uint32_t side) {
    return {float(cell % side) + 0.5f, float(cell / side) + 0.5f, 0.0f};
}

}  // namespace raygraph::testing
