// Access to the value that an AnimationTarget refers to: its width, getting it and setting it. Internal to
// renderer/scene. Threads: pure functions of their arguments.
#pragma once

#include <cstddef>
#include <optional>

#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Returns whether the target is the weights of morph targets: all of them, or one.
constexpr bool IsMorphWeights(const AnimationTarget& target) {
    return target.property == AnimatedProperty::Weights || target.property == AnimatedProperty::MeshWeights;
}

// Some fields are limited by another one: an inner cone angle by the outer one, zNear by zFar, a strength by
// its color, because their product must be finite. SetValue clamps such a follower against the other field's
// value in the scene, which must be set before. DependentOf returns the field that `target` limits, if any.
std::optional<AnimationTarget> DependentOf(const AnimationTarget& target);
bool IsDependent(const AnimationTarget& target);

// Returns whether 0 means infinite for the field.
bool IsInfiniteAtZero(const AnimationTarget& target);

// Returns how many numbers the target's value has; 0 if the scene has no such target, or none that can be
// animated.
size_t WidthOf(const SceneData& scene, const AnimationTarget& target);

// Gets the value of a target for which WidthOf is not 0, as numbers. Rotations are x, y, z, w; flags 0 or 1.
void GetValue(const SceneData& scene, const AnimationTarget& target, double* value);

// Sets the whole value of a target for which WidthOf is not 0. Numbers are clamped to the range of their
// field, and a flag is true if the number is at least 0.5; so the scene stays one that Check accepts. Returns
// whether the scene has changed. A node's matrix stays, and overrides what is set.
bool SetValue(SceneData& scene, const AnimationTarget& target, const double* value);

}  // namespace raygraph::scene
