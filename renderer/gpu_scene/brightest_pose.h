// What a scene makes shine in the pose that it has, or may make shine as its animations play. Threads: a pure
// function, for any thread.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/scene_data.h"

namespace raygraph {

// Each value is the greatest, by component, of that of the pose and of all keys of animations: those of
// different animations may come together.
struct BrightestPose {
    std::vector<bool> visibleNodes;      // as scene::VisibleNodes has them
    std::vector<glm::vec3> emission;     // of each material: EmittedRadiance
    std::vector<glm::vec3> unlitColors;  // of each material that is unlit: its base color; 0 of others
    bool hasLight = false;               // a punctual light shines
};

// The scene is valid (renderer/scene/check.h).
BrightestPose FindBrightestPose(const scene::SceneData& scene);

}  // namespace raygraph
