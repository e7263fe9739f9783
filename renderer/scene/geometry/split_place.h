// A place in double as two floats. Threads: pure functions, for any thread.
#pragma once

#include <glm/glm.hpp>

#include "base/api.h"

namespace raygraph::scene {

struct SplitPlace {
    glm::vec3 rounded{0.0f};  // to float
    glm::vec3 rest{0.0f};     // the remainder of the rounding
};
RAYGRAPH_API SplitPlace Split(const glm::dvec3& place);

}  // namespace raygraph::scene
