// A local transform as the numbers that a user edits. Threads: pure functions, for any thread.
#pragma once

#include <glm/glm.hpp>

namespace raygraph::editor {

struct Placement {
    glm::vec3 translation{0.0f};
    glm::vec3 degrees{0.0f};  // about x, then y, then z
    glm::vec3 scale{1.0f};    // lengths of the columns; x is negative if the transform mirrors
};

// Of a transform that shears, the rotation is that of its first axis and of the plane of the first two.
Placement PlacementOf(const glm::mat4x3& local);

// `local` with the differences between `before`, its placement, and `after`: parts that are equal there stay
// in the matrix to the bit, and shear stays whatever is edited. A column of no length has none.
glm::mat4x3 Placed(const glm::mat4x3& local, const Placement& before, const Placement& after);

}  // namespace raygraph::editor
