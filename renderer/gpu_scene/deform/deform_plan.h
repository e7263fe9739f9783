// Which deformed copies of its meshes a scene needs. Threads: pure functions of their arguments.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// A mesh as it is deformed by a skin and by the weights of a node. Instances that agree in these share a
// copy. With targets and without a node, an instance has a copy of its own.
struct DeformedCopy {
    uint32_t mesh = 0;
    uint32_t skin = scene::kNone;  // kNone: no skin deforms it
    bool hasTargets = false;       // morph targets move it
    std::vector<uint32_t> instances;
};

struct DeformPlan {
    std::vector<DeformedCopy> copies;  // by mesh, ascending
    std::vector<uint32_t> copyOf;      // by instance; kNone: it is not deformed
    // By mesh: some instance of it is not deformed, or it has no instance.
    std::vector<bool> isBaseShapeDrawn;
};

// Must be called before the scene's meshes are consumed.
DeformPlan PlanDeformation(const scene::SceneData& scene);

}  // namespace raygraph
