// Animations, and the skins whose joints they move. Value types, and the value of a sampler at a time (glTF
// 2.0, section 3.11 and appendix C).
//
// Holds for a scene that is valid (renderer/scene/model/check.h):
//   - times are finite and ascend strictly, and there is at least one;
//   - values are finite, as many as the interpolation wants of them, quaternions not of length 0;
//   - a channel's sampler and object exist, its property is one that the object has, and its sampler is as
//     wide as the property;
//   - a skin has 1 to kMaxJoints joints, which are nodes, and an inverse bind matrix for each.
//
// Threads: plain values; pure functions, for any thread.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "base/api.h"
#include "renderer/scene/model/mesh_data.h"

namespace raygraph::scene {

enum class Interpolation : uint8_t {
    Step,         // the value of the key before
    Linear,       // straight from key to key; rotations along the shortest arc, at constant speed
    CubicSpline,  // Hermite, with tangents per second at each key; rotations normalized after it
};

// Holds values over time. `width` numbers make a value: 3 of a translation, 4 (x, y, z, w) of a rotation, as
// many as there are targets of weights.
struct AnimationSampler {
    Interpolation interpolation = Interpolation::Linear;
    uint32_t width = 1;
    std::vector<float> times;  // in seconds
    // A value for each time. CubicSpline: three, which are the tangent before, the value and the tangent
    // after.
    std::vector<float> values;
};

// The property that a channel changes.
enum class AnimatedProperty : uint8_t {
    Translation,  // the node `object`; also Rotation and Scale
    Rotation,     //
    Scale,        //
    // Mesh::weights of the mesh `object`: all, or the one of `element`. For nodes without their own.
    MeshWeights,
    Weights,           // the node `object`: its own weights, all or the one of `element`
    Visibility,        // and Node::isVisible: not 0
    MaterialField,     // the material `object`, field `field` of material_fields::kAll
    TextureTransform,  // or field `element` of kTransformFields of the texture that this field is.
    CameraField,       // the camera `object`, field `field` of camera_fields::kAll
    LightField,        // the light `object`, field `field` of light_fields::kAll
};

struct AnimationTarget {
    AnimatedProperty property = AnimatedProperty::Translation;
    uint8_t field = 0;
    uint32_t object = 0;       // Into the list of SceneData that the property says.
    uint32_t element = kNone;  // kNone: the whole

    auto operator<=>(const AnimationTarget&) const = default;
};

struct AnimationChannel {
    uint32_t sampler = 0;  // index into Animation::samplers
    AnimationTarget target;
};

struct Animation {
    std::string name;
    std::vector<AnimationSampler> samplers;
    std::vector<AnimationChannel> channels;  // no two of the same target
    float duration = 0.0f;                   // seconds: the last time of all samplers; 0 without any
    // The defect that LoadGltf found in the keys of something that pictures show: one line with the file, the
    // place and the value. Such an animation cannot be played (RequirePlayable in pose.h). Empty: none.
    std::string defect = {};
};

// Holds the joints that deform a mesh, each a node. Which nodes have it says Node::skin.
struct Skin {
    std::string name;
    std::vector<uint32_t> joints;  // Into SceneData::nodes, all of them in nodeOrder if a placed node has it.
    // One a joint: from the mesh's object space to that of the joint, as they were when the mesh was bound
    // to it.
    std::vector<glm::mat4x3> inverseBinds;

    static constexpr size_t kMaxJoints = 65535;
};

// The value of a sampler at a time, `width` numbers; before the first key that of the first, after the last
// that of the last. A rotation is 4 numbers wide and said to be one; the result has unit length. `interval`
// is where to look for the time first, and becomes where it was found: 0 to begin with, kept for the next
// time of the same sampler.
RAYGRAPH_API void SampleAnimation(const AnimationSampler& sampler, double seconds, bool isRotation,
                                  uint32_t& interval, double* value);

}  // namespace raygraph::scene
