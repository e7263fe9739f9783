// Placement is a local transform as numbers that a user edits. Threads: pure functions, for any thread.
#pragma once

#include <glm/glm.hpp>

namespace raygraph::editor {

struct Placement {
    glm::vec3 translation{0.0f};
    glm::vec3 degrees{0.0f};  // rotations about x, then y, then z
    glm::vec3 scale{1.0f};    // lengths of the columns; x is negative for a mirroring transform
};

// For a transform with shear, the rotation is that of its first axis and of the plane of its first two.
Placement PlacementOf(const glm::mat4x3& local);

// Applies to `local` the differences between `before`, its placement, and `after`. Equal parts of both keep
// their bits in the matrix, and shear is kept. A column of length 0 has none.
glm::mat4x3 Placed(const glm::mat4x3& local, const Placement& before, const Placement& after);

}  // namespace raygraph::editor
