// Placed meshes, and the wide trees over them as scene/wide_bvh.glsl traverses them. Threads: pure
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

// The wide tree of a mesh: children and triangles count from its own first ones.
struct WideMesh {
    std::vector<gpu::WideNode> nodes;  // none: the tree is not built yet
    std::vector<gpu::WideTriangle> triangles;
    Box box;
    uint32_t depth = 0;
    double sahCost = 0.0;
};
// Of the triangles that have an area: rounding might let rays hit others.
RAYGRAPH_API WideMesh CollectTriangles(std::span<const glm::vec3> positions,
                                       std::span<const uint32_t> indices);
// Builds the tree; none of triangles that reach farther than 1e18. One that would be deeper than
// kMaxMeshDepth is built again, balanced. `maxThreads` as of BvhSettings.
RAYGRAPH_API void BuildTree(WideMesh& mesh, uint32_t maxThreads = 0);
// Both.
RAYGRAPH_API WideMesh BuildWideMesh(std::span<const glm::vec3> positions, std::span<const uint32_t> indices,
                                    uint32_t maxThreads = 0);

// The triangles of a WideMesh where an instance places them.
struct PlacedTriangles {
    std::span<const gpu::WideTriangle> triangles;
    glm::mat4x3 objectToWorld{1.0f};
    uint32_t number = 0;
    uint32_t flags = 0;  // gpu::kWideBackCulled, ...
};
// A tree of one level: its triangles are those of all instances in one space. Those that have no area there
// are left out, and as by BuildWideInstances all those of some instances.
RAYGRAPH_API WideMesh BuildWideLevel(std::span<const PlacedTriangles> placed);
// With more triangles, building it takes longer than it saves.
inline constexpr uint64_t kMaxLevelTriangles = 1 << 19;

// A placed tree of a mesh.
struct WidePlacement {
    glm::mat4x3 objectToWorld{1.0f};
    Box box;  // of the mesh; empty: it has no triangles
    uint32_t root = 0;
    uint32_t number = 0;
    uint32_t flags = 0;  // gpu::kWideBackCulled, ...
};
struct WideInstances {
    std::vector<gpu::WideNode> nodes;          // children count from their own first one
    std::vector<gpu::WideInstance> instances;  // the first is none; set its root
    uint32_t depth = 0;
    double sahCost = 0.0;
};
// Those without triangles, those whose transforms have no inverse, and those that reach
// farther than 1e18 are left out: no ray meets them.
RAYGRAPH_API WideInstances BuildWideInstances(std::span<const WidePlacement> placements);

// Of nodes, children and primitives included, that are moved to other places in their tables.
RAYGRAPH_API void MoveNodes(std::span<gpu::WideNode> nodes, uint32_t firstNode, uint32_t firstPrimitive);

// As many levels as there is room for while a ray is traversed: a level leaves one group behind, and going
// into a mesh another one.
inline constexpr uint32_t kMaxMeshDepth = 18;
inline constexpr uint32_t kMaxInstanceDepth = gpu::kWideStackSize - 1 - kMaxMeshDepth;

struct WideScene {
    std::vector<gpu::WideNode> nodes;
    std::vector<gpu::WideTriangle> triangles;
    std::vector<gpu::WideInstance> instances;
    double sahOfInstances = 0.0;  // WideBvh::sahCost of the tree of instances,
    double sahOfMeshes = 0.0;     // and that of meshes, weighted by their numbers of triangles
    double buildSeconds = 0.0;
};

// Error{Usage} for trees that are too deep.
RAYGRAPH_API WideScene BuildWideScene(const BvhScene& scene);
// Of one level, likewise.
RAYGRAPH_API WideScene BuildOneLevel(const BvhScene& scene);

RAYGRAPH_API std::vector<Box> TriangleBoxes(std::span<const glm::vec3> positions,
                                            std::span<const uint32_t> indices);
inline std::vector<Box> TriangleBoxes(const BvhMesh& mesh) {
    return TriangleBoxes(mesh.positions, mesh.indices);
}
// The box around the corners of the mesh's box, placed; a little larger than rounding may make it.
RAYGRAPH_API Box PlacedBox(const Box& mesh, const glm::mat4x3& objectToWorld);
RAYGRAPH_API std::vector<Box> InstanceBoxes(const BvhScene& scene);

}  // namespace raygraph
