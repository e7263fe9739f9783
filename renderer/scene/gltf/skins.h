// Skins, the joints and weights of vertices, and morph targets. Internal to renderer/scene.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/document.h"
#include "renderer/scene/gltf/meshes.h"
#include "renderer/scene/gltf/nodes.h"
#include "renderer/scene/gltf/reader.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Checks all skins and fills scene.skins but for their matrices, and each node's skin and weights. A skin
// that its node has no use for is left out with a warning.
void ReadSkins(GltfContext& context, const GltfDocument& document, const AccessorTables& tables,
               const std::vector<MeshLayout>& layouts, const std::vector<InstancingLayout>& instancing,
               SceneData& scene);

// The inverse bind matrices of all skins that deform something; those of the others stay the identity.
void DecodeSkins(GltfContext& context, AccessorReader& reader, const std::vector<SkinSource>& sources,
                 SceneData& scene);

// Returns, by mesh, the skin with the fewest joints among those of the placed nodes that have the mesh.
std::vector<JointLimit> JointLimits(const SceneData& scene, size_t meshCount);

// Decodes joints and weights of the selected vertices into JointInfluences, without the boxes. `packed` holds
// the bytes of attributes that were compressed.
JointInfluences DecodeInfluences(GltfContext& context, AccessorReader& reader, const PrimitiveLayout& layout,
                                 const ElementSelection& vertices, const JointLimit& limit,
                                 const std::array<std::vector<std::byte>, kAttributeCount>& packed);

// --- Morph targets: displacements of vertices, and their weights ---

// Returns the weights that a mesh or a node has: none, or one a target. Fails at `where` otherwise.
std::vector<float> ReadMorphWeights(GltfContext& context, const std::vector<double>& file, size_t targetCount,
                                    const Place& where);

// Decodes the targets of `vertices`; `tangents` are the same for tangents. Normals and tangents have
// displacements only where the file has them, and a stream of only zeros is left out. Boxes are not filled.
std::vector<MorphTarget> DecodeTargets(GltfContext& context, AccessorReader& reader,
                                       const PrimitiveLayout& layout, const ElementSelection& vertices,
                                       const ElementSelection& tangents);

}  // namespace raygraph::scene
