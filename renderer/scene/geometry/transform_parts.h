// A local transform as translation, rotation and scale, as a node without a matrix has it. Threads: pure
// functions, for any thread.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>

#include "base/api.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

struct TransformParts {
    glm::vec3 translation{0.0f};
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};  // unit length
    glm::vec3 scale{1.0f};
};

// The parts that make `local` but for rounding of products of such matrices, as many as may be the node's own
// to the bit; nothing if it shears, or is flat.
RAYGRAPH_API std::optional<TransformParts> PartsOf(const glm::mat4x3& local, const Node& own);

}  // namespace raygraph::scene
