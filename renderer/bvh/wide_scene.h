// Placed meshes, and the wide trees over them as scene/wide_bvh.glsl traverses them. Threads: pure
// functions.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
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

// Holds the wide tree of a mesh: children and triangles count from its own first ones.
struct WideMesh {
    std::vector<gpu::WideNode> nodes;  // none: the tree is not built yet
    std::vector<gpu::WideTriangle> triangles;
    Box box;
    uint32_t depth = 0;
};
// Returns the triangles that have an area: rounding might let rays hit others.
RAYGRAPH_API WideMesh CollectTriangles(std::span<const glm::vec3> positions,
                                       std::span<const uint32_t> indices);
// Builds the tree, sorts the triangles by its leaves, and returns their original indices. There is no tree of
// triangles that reach farther than 1e18. A tree that would be deeper than kMaxMeshDepth is built again,
// balanced. `maxThreads` is that of BvhSettings.
RAYGRAPH_API std::vector<uint32_t> BuildTree(WideMesh& mesh, uint32_t maxThreads = 0);
// Holds the triangles of a WideMesh where an instance places them.
struct PlacedTriangles {
    std::span<const gpu::WideTriangle> triangles;
    glm::mat4x3 objectToWorld{1.0f};
    uint32_t number = 0;
    uint32_t flags = 0;  // gpu::kWideBackCulled, ...
};
// Returns these triangles in the space of the scene. One that has no area there is a point, which no ray
// hits. Nothing for a transform without an inverse in float, and for triangles that reach farther than 1e18.
RAYGRAPH_API std::optional<std::vector<gpu::WideTriangle>> PlaceTriangles(const PlacedTriangles& placed);
// Holds a tree of one level: its triangles are those of all instances in one space, but for instances that
// PlaceTriangles leaves out.
struct WideLevel {
    WideMesh mesh;
    struct Source {
        uint32_t placed = 0, triangle = 0;  // index into `placed`, and the triangle's index in that
    };
    std::vector<Source> sources;  // sources of the mesh's triangles
};
RAYGRAPH_API WideLevel BuildWideLevel(std::span<const PlacedTriangles> placed);
// With more triangles, building the level once takes longer than it saves, and building it in a frame takes
// longer than a frame should.
inline constexpr uint64_t kMaxLevelTriangles = 1 << 19, kMaxRebuiltTriangles = 1 << 16;

// Describes a placed tree of a mesh.
struct WidePlacement {
    glm::mat4x3 objectToWorld{1.0f};
    Box box;  // box of the mesh; empty: it has no triangles
    uint32_t root = 0;
    uint32_t number = 0;
    uint32_t flags = 0;  // gpu::kWideBackCulled, ...
};
struct PlacedInstance {
    gpu::WideInstance instance;
    Box box;  // in the space of the scene
};
// Returns nullopt for an instance that no ray can hit: one without triangles, one whose transform has no
// inverse, and one that reaches farther than 1e18.
RAYGRAPH_API std::optional<PlacedInstance> PlaceInstance(const WidePlacement& placement);
struct WideInstances {
    std::vector<gpu::WideNode> nodes;          // children count from their own first one
    std::vector<gpu::WideInstance> instances;  // the first is unused; set its root
    std::vector<Box> boxes;                    // boxes of these instances
    std::vector<uint32_t> placements;          // by instance: its placement; the first is unused
    uint32_t depth = 0;
};
// Builds the tree over the placements that PlaceInstance returns.
RAYGRAPH_API WideInstances BuildWideInstances(std::span<const WidePlacement> placements);

// Adjusts the indices of nodes, their children and primitives for new positions in their tables.
RAYGRAPH_API void MoveNodes(std::span<gpu::WideNode> nodes, uint32_t firstNode, uint32_t firstPrimitive);

// The traversal stack has room for this depth: each level pushes one group, and entering a mesh another
// one.
inline constexpr uint32_t kMaxMeshDepth = 18;
inline constexpr uint32_t kMaxInstanceDepth = gpu::kWideStackSize - 1 - kMaxMeshDepth;

struct WideScene {
    std::vector<gpu::WideNode> nodes;
    std::vector<gpu::WideTriangle> triangles;
    std::vector<gpu::WideInstance> instances;
};

// Builds a tree of one level. Throws Error{Usage} for a tree that is too deep.
RAYGRAPH_API WideScene BuildOneLevel(const BvhScene& scene);

// Returns the box around the corners of the mesh's box, placed; a little larger than rounding may make it.
RAYGRAPH_API Box PlacedBox(const Box& mesh, const glm::mat4x3& objectToWorld);

}  // namespace raygraph
