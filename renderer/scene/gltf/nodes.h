// scenes, nodes, cameras, lights: the graph. Internal to renderer/scene.
#pragma once

#include <vector>

#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/instancing.h"
#include "renderer/scene/gltf/model.h"
#include "renderer/scene/gltf/reader.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// The file's indices of what the scene has.
struct GraphIndices {
    uint32_t scene = kNone;          // kNone: the file has no scenes.
    std::vector<uint32_t> profiles;  // the file's index of each element of SceneData::profiles
    std::vector<uint32_t> cameras;   // By SceneData::cameras.
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

// The file's cameras and lights, not yet placed. gltf/cameras_lights.cpp.
std::vector<Camera> ReadCameras(GltfContext& context, const gltf::Model& model);
std::vector<Light> ReadLights(GltfContext& context, const gltf::Model& model);

}  // namespace raygraph::scene
