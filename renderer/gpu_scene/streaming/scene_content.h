// The content of a PreparedScene. For renderer/gpu_scene alone. Threads: plain values.
#pragma once

#include <vector>

#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/geometry/mesh_packing.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

struct PreparedContent {
    scene::SceneData data;           // its primitives have been moved out
    std::vector<PackedMesh> meshes;  // in the order of the data's meshes
    DeformPlan deform;
    bool hasOwnLight = false;  // see own_light.h; an environment does not count
};

}  // namespace raygraph
