// Compares the results of two loads.
#pragma once

#include "renderer/scene/model/scene_data.h"

namespace raygraph::test {

// The greatest distance of two columns.
float Apart(const glm::mat4x3& a, const glm::mat4x3& b);

// Expects all that a file says to be alike. `tolerance` of transforms; 0: to the bit.
void ExpectSame(const scene::SceneData& a, const scene::SceneData& b, float tolerance = 0.0f);

}  // namespace raygraph::test
