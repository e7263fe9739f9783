// FindBrightestPose finds what shines in the pose that a scene has, or may shine as its animations play.
// Threads: a pure function, for any thread.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// Each value is the greatest, by component, of the pose and of all keys of all animations, as if these came
// together.
struct BrightestPose {
    std::vector<bool> visibleNodes;      // as scene::VisibleNodes has them
    std::vector<glm::vec3> emission;     // of each material: EmittedRadiance
    std::vector<glm::vec3> unlitColors;  // of each material that is unlit: its base color; 0 of others
    bool hasLight = false;               // a punctual light shines
};

// The scene is valid (renderer/scene/model/check.h).
BrightestPose FindBrightestPose(const scene::SceneData& scene);

}  // namespace raygraph
