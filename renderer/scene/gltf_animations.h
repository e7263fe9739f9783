// Animations: their channels, and what a scene has of each. Internal to renderer/scene.
#pragma once

#include <string>
#include <vector>

#include "renderer/scene/gltf_accessors.h"
#include "renderer/scene/gltf_context.h"
#include "renderer/scene/gltf_document.h"
#include "renderer/scene/gltf_meshes.h"
#include "renderer/scene/gltf_pointer.h"
#include "renderer/scene/gltf_reader.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::scene {

// A sampler whose accessors are of fitting types and counts; nothing is decoded yet.
struct SamplerLayout {
    Place where;
    uint32_t input = 0, output = 0;
    Interpolation interpolation = Interpolation::Linear;
    ValueKind kind = ValueKind::Plain;
    uint32_t width = 1;
    bool isOfWeights = false;  // Which are scalars in the file.
};

struct AnimationLayout {
    std::string name;
    std::vector<SamplerLayout> samplers;  // Those that channels use, one for each kind of value.
    std::vector<AnimationChannel> channels;
};

// Reads and checks all of the file's animations. Channels of what is not read, or not there, the later ones
// of a target and those with a wrong number of values are left out with a warning.
std::vector<AnimationLayout> ReadAnimations(GltfContext& context, const std::vector<AnimationSource>& sources,
                                            const AccessorTables& tables,
                                            const std::vector<MeshLayout>& meshes,
                                            const PointedScene& pointed);

// Channels whose times do not ascend, or with a quaternion of length 0, are left out with a warning.
std::vector<Animation> DecodeAnimations(GltfContext& context, AccessorReader& reader,
                                        const std::vector<AnimationLayout>& layouts);

}  // namespace raygraph::scene
