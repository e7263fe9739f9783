// Animations: their channels, and what a scene has of each. Internal to renderer/scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/document.h"
#include "renderer/scene/gltf/meshes.h"
#include "renderer/scene/gltf/pointer.h"
#include "renderer/scene/gltf/reader.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Describes a defect in the keys of a sampler. `topic` is that of its warning.
struct KeyDefect {
    Place where;
    const char* topic;
    std::string what;
};

// Describes a sampler whose accessors are of fitting types; nothing is decoded yet.
struct SamplerLayout {
    Place where;
    uint32_t input = 0, output = 0;
    Interpolation interpolation = Interpolation::Linear;
    ValueKind kind = ValueKind::Plain;
    uint32_t width = 1;
    bool isMorphWeights = false;           // Which are scalars in the file.
    bool isShown = false;                  // pictures show the target of one of its channels
    std::optional<KeyDefect> defect = {};  // Its values are not as many as its keys need.
};

struct AnimationLayout {
    std::string name;
    std::vector<SamplerLayout> samplers;  // those that channels use, once for each kind of value
    std::vector<AnimationChannel> channels;
};

// Reads and checks all of the file's animations. Channels whose target is not read or missing, and all but
// the first of a target, are left out with a warning. The scene has its nodes, skins and materials; `layouts`
// are its meshes.
std::vector<AnimationLayout> ReadAnimations(GltfContext& context, const std::vector<AnimationSource>& sources,
                                            const AccessorTables& tables,
                                            const std::vector<MeshLayout>& meshes,
                                            const PointerScene& pointed);

// Channels whose keys are not finite, do not ascend from a time that is not negative, have another number of
// values or a quaternion of length 0 are left out, with a warning for each sampler. Where pictures show a
// target of the sampler, the animation has the defect (Animation::defect).
std::vector<Animation> DecodeAnimations(GltfContext& context, AccessorReader& reader,
                                        const std::vector<AnimationLayout>& layouts);

}  // namespace raygraph::scene
