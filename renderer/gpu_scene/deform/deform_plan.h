// Which deformed copies of its meshes a scene needs. Threads: pure functions of their arguments.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// A mesh as deformed by a skin and the weights of a node: the instances that agree in these share it. With
// targets and without a node, an instance has one of its own.
struct DeformedCopy {
    uint32_t mesh = 0;
    uint32_t skin = scene::kNone;  // kNone: no joints move it
    bool hasTargets = false;       // morph targets move it
    std::vector<uint32_t> instances;
};

struct DeformPlan {
    std::vector<DeformedCopy> copies;    // by mesh, ascending
    std::vector<uint32_t> copyOf;        // by instance; kNone: it is not deformed
    std::vector<bool> isBaseShapeDrawn;  // by mesh: an instance of it is not deformed, or there is none
};

// Before the scene's meshes are consumed.
DeformPlan PlanDeformation(const scene::SceneData& scene);

}  // namespace raygraph
