// EXT_mesh_gpu_instancing: a node's mesh placed many times. Internal to renderer/scene.
#pragma once

#include <vector>

#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/reader.h"

namespace raygraph::scene {

// The accessors of one node's instances, of fitting types and of one count; nothing is decoded yet.
struct InstancingLayout {
    Place where;  // Its "attributes".
    uint32_t translation = kNone, rotation = kNone, scale = kNone;
    uint64_t count = 0;  // 0: the node's mesh is placed once, by the node alone.
};

// Returns one layout per node of the file. Checks all nodes that have the extension, whether or not they are
// placed.
std::vector<InstancingLayout> ReadInstancing(GltfContext& context, const gltf::Model& model,
                                             const AccessorTables& tables);

// The transforms from the mesh to its node. The caller has charged their memory.
std::vector<glm::mat4x3> DecodeInstancing(GltfContext& context, AccessorReader& reader,
                                          const InstancingLayout& layout);

}  // namespace raygraph::scene
