// FindBrightestPose finds what shines in the pose that a scene has, or may shine as its animations play.
// Threads: a pure function.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// Each value is the greatest, by component, over the pose and all keys of all animations, as if these
// occurred together.
struct BrightestPose {
    std::vector<bool> visibleNodes;      // as scene::VisibleNodes returns them
    std::vector<glm::vec3> emission;     // by material: EmittedRadiance
    std::vector<glm::vec3> unlitColors;  // by material: the base color if it is unlit, otherwise 0
    bool hasLight = false;               // some punctual light shines
};

// Requires a valid scene (renderer/scene/model/check.h).
BrightestPose FindBrightestPose(const scene::SceneData& scene);

}  // namespace raygraph
