// Morph targets: displacements of vertices, and their weights. Internal to renderer/scene.
#pragma once

#include <vector>

#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/meshes.h"
#include "renderer/scene/gltf/reader.h"

namespace raygraph::scene {

// The weights that a mesh or a node has: none, or one a target. Fails at `where` otherwise.
std::vector<float> ReadMorphWeights(GltfContext& context, const std::vector<double>& file, size_t targetCount,
                                    const Place& where);

// Decodes the targets of `vertices`; `tangents` are the same for tangents. Normals and tangents have
// displacements only where the file has them, and a stream of only zeros is left out. Boxes are not filled.
std::vector<MorphTarget> DecodeTargets(GltfContext& context, AccessorReader& reader,
                                       const PrimitiveLayout& layout, const ElementSelection& vertices,
                                       const ElementSelection& tangents);

}  // namespace raygraph::scene
