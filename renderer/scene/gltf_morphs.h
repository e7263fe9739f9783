// Morph targets: displacements of vertices, and their weights. Internal to renderer/scene.
#pragma once

#include <vector>

#include "renderer/scene/gltf_context.h"
#include "renderer/scene/gltf_meshes.h"
#include "renderer/scene/gltf_reader.h"

namespace raygraph::scene {

// The weights that a mesh or a node has: none, or one a target. Fails at `where` otherwise.
std::vector<float> ReadMorphWeights(GltfContext& context, const std::vector<double>& file, size_t targetCount,
                                    const Place& where);

// Of the vertices named, which are the same for tangents. Displacements of normals and tangents only where
// the file has these; a stream of nothing but zeros is left out. Boxes are not filled.
std::vector<MorphTarget> DecodeTargets(GltfContext& context, AccessorReader& reader,
                                       const PrimitiveLayout& layout, const ElementSelection& vertices,
                                       const ElementSelection& tangents);

}  // namespace raygraph::scene
