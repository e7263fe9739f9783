// Access to the value that an AnimationTarget refers to: its width, getting it and setting it. Internal to
// renderer/scene. Threads: pure functions of their arguments.
#pragma once

#include <cstddef>
#include <optional>

#include "renderer/scene/scene_data.h"

namespace raygraph::scene {

// Returns whether the target is the weights of morph targets: all of them, or one.
constexpr bool IsOfWeights(const AnimationTarget& target) {
    return target.property == AnimatedProperty::Weights || target.property == AnimatedProperty::MeshWeights;
}

// Some fields are kept legal beside another one: an inner cone angle below the outer one, zNear below zFar, a
// strength beside a color whose product is to be finite. These follow: SetValue clamps them against the other
// one's value in the scene, which is to be set before. What follows `target`, if it leads; and whether it
// follows.
std::optional<AnimationTarget> FollowerOf(const AnimationTarget& target);
bool IsFollower(const AnimationTarget& target);

// Returns whether it is a field of which 0 means infinite.
bool IsInfiniteAtZero(const AnimationTarget& target);

// How many numbers the target's value has; 0: the scene has no such thing, or nothing that could be animated.
size_t WidthOf(const SceneData& scene, const AnimationTarget& target);

// Gets the value of a target for which WidthOf is not 0, as numbers. Rotations are x, y, z, w; flags 0 or 1.
void GetValue(const SceneData& scene, const AnimationTarget& target, double* value);

// Sets the whole value of a target for which WidthOf is not 0. Numbers are clamped to the range of their
// field, and a flag is true if the number is at least 0.5; so the scene stays one that Check accepts. Returns
// whether the scene has changed. A node's matrix stays, and overrides what is set.
bool SetValue(SceneData& scene, const AnimationTarget& target, const double* value);

}  // namespace raygraph::scene
