// The graph of a glTF file: its scenes, nodes, cameras and lights, the instances of nodes, and the radii of
// points and lines. Internal to renderer/scene.
#pragma once

#include <vector>

#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/model.h"
#include "renderer/scene/gltf/reader.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// --- EXT_mesh_gpu_instancing: a node's mesh placed many times ---

// Holds the accessors of one node's instances, of fitting types and of one count; nothing is decoded yet.
struct InstancingLayout {
    Place where;  // its "attributes"
    uint32_t translation = kNone, rotation = kNone, scale = kNone;
    uint64_t count = 0;  // 0: the node's mesh is placed once, by the node alone.
};

// Returns one layout per node of the file. Checks all nodes that have the extension, whether or not they are
// placed.
std::vector<InstancingLayout> ReadInstancing(GltfContext& context, const gltf::Model& model,
                                             const AccessorTables& tables);

// Returns the transforms from the mesh to its node. The caller has charged their memory.
std::vector<glm::mat4x3> DecodeInstancing(GltfContext& context, AccessorReader& reader,
                                          const InstancingLayout& layout);

// --- The graph ---

// The file's indices of what the scene has.
struct GraphIndices {
    uint32_t scene = kNone;          // kNone: the file has no scenes.
    std::vector<uint32_t> profiles;  // the file's index of each element of SceneData::profiles
    std::vector<uint32_t> cameras;   // by SceneData::cameras
    std::vector<uint32_t> lights;    // By SceneData::lights, without those that have a profile.
};

// Fills scene.name, nodes, nodeOrder, cameras and lights; transforms of the latter two are still identity.
// Checks that the nodes form a forest and that every index is in range. Throws Error{Usage} if options.scene
// does not exist.
GraphIndices ReadNodes(GltfContext& context, const gltf::Model& model, SceneData& scene);

// Places an instance for every node of scene.nodeOrder with a mesh, or as many as `instancing` has of the
// node, then world transforms and bounds. Fails if a transform or the bounds are not finite.
void PlaceInstances(GltfContext& context, AccessorReader& reader,
                    const std::vector<InstancingLayout>& instancing, SceneData& scene);

// --- The radii of points and lines of a file ---

// Returns the value that a decoded primitive has as its radii until SetRadii replaces it.
float RequestedRadius(const RoundRadius& requested);

// Sets the radii so that they are those asked for in world space, and extends all bounds by them. Call it
// when everything is placed. If a mesh has several placements, the largest gets the radius asked for; if its
// scale differs by axis, the radius is that of the sphere with the ellipsoid's volume.
void SetRadii(GltfContext& context, SceneData& scene);

}  // namespace raygraph::scene
