// Placed meshes, and the wide trees over them as bench/wide_bvh.glsl traverses them. Threads: pure
// functions.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "base/api.h"
#include "renderer/bvh/box.h"
#include "shaders/shared/wide_bvh.h"

namespace raygraph {

struct BvhMesh {
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> indices;  // three a triangle; there are some
    size_t TriangleCount() const { return indices.size() / 3; }
};
struct BvhInstance {
    uint32_t mesh = 0;
    glm::mat4x3 objectToWorld{1.0f};
};
struct BvhScene {
    std::vector<BvhMesh> meshes;
    std::vector<BvhInstance> instances;
};

struct WideScene {
    std::vector<gpu::WideNode> nodes;  // first those of the tree of instances
    std::vector<gpu::WideTriangle> triangles;
    std::vector<gpu::WideInstance> instances;
    double sahOfInstances = 0.0;  // WideBvh::sahCost of the tree of instances,
    double sahOfMeshes = 0.0;     // and that of meshes, weighted by their numbers of triangles
    double buildSeconds = 0.0;
};

// Error{Usage} for trees that are too deep for kWideStackSize.
RAYGRAPH_API WideScene BuildWideScene(const BvhScene& scene);

RAYGRAPH_API std::vector<Box> TriangleBoxes(const BvhMesh& mesh);
// The box around the corners of the mesh's box, placed; a little larger than rounding may make it.
RAYGRAPH_API std::vector<Box> InstanceBoxes(const BvhScene& scene);

}  // namespace raygraph
