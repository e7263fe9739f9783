// The pose of a scene at a time: a Pose is computed from the clips of animations, and PoseApplier
// (pose_applier.h) applies it.
//
//   scene::PoseEvaluator evaluator(data);                     // keeps the rest pose
//   scene::PoseApplier applier(data);
//   for (;;) {
//       const scene::Pose& pose = evaluator.Evaluate(data, std::array{scene::ClipState{walk, seconds}});
//       Upload(applier.Apply(data, pose));                    // what has changed, as lists of indices
//   }
//
// Threads: exclusive access to an evaluator; it only reads the scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/api.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// An animation that plays, at a time and with a weight. Before its first key a property has the value of
// that, after its last key of the last. Who wants a loop, takes the time modulo Animation::duration.
struct ClipState {
    uint32_t animation = 0;  // Into SceneData::animations.
    double seconds = 0.0;
    float weight = 1.0f;  // 0 or less: as if it were not there.

    bool operator==(const ClipState&) const = default;
};

// Throws Error{BadInput} with Animation::defect if one of the clips that has a weight is of an animation with
// a defect, and Error{Usage} if there is no such animation.
RAYGRAPH_API void RequirePlayable(const SceneData& scene, std::span<const ClipState> clips);

// A property that some animation of the scene changes, and where its value is in Pose::values.
struct PosedProperty {
    AnimationTarget target;  // A whole: of weights all.
    size_t first = 0;
    size_t count = 0;
};

// The values of all that any animation of the scene changes, whether or not a clip does now, and of what has
// to be kept legal beside it (a spot's inner cone angle beside the outer one): what none changes has its rest
// value. Numbers are not yet in the range of their field; rotations are x, y, z, w of unit
// length; flags are their share, of which half is true.
struct Pose {
    std::vector<PosedProperty>
        properties;  // In the order of their targets; the same in every pose of a scene.
    std::vector<double> values;
};

class RAYGRAPH_API PoseEvaluator {
  public:
    // The scene's values are the rest pose. Channels of a node with a matrix are left out: it says what
    // counts.
    explicit PoseEvaluator(const SceneData& scene);

    // The pose of some clips, which may be none, and may name one animation several times. A property is the
    // weighted mean of the clips that have a channel for it. Where their weights sum to less than 1, the rest
    // value has the remainder; above, they count by their share. Rotations are added as quaternions, each
    // turned to the side of the sum so far, and normalized; fields whose 0 is infinite by their reciprocals.
    // `scene` is that of the constructor, whose animations are as they were; its values are not read. Valid
    // until the next call. No memory is allocated. Throws what RequirePlayable throws.
    const Pose& Evaluate(const SceneData& scene, std::span<const ClipState> clips);

    // The scene's own, with nothing animated.
    const Pose& Rest();

    // Reads the rest values of these properties from the scene, after an edit of a scene that has its rest
    // pose.
    void ReadRest(const SceneData& scene);

  private:
    struct Channel {
        uint32_t sampler = 0;
        size_t first = 0;       // in the values of a pose
        uint32_t interval = 0;  // where the last time was found
        bool isRotation = false;
    };

    void Add(const AnimationSampler& sampler, Channel& channel, double seconds, double weight);
    void Finish(const PosedProperty& property);

    Pose m_pose;
    std::vector<double> m_rest, m_totals, m_sample;  // totals: of weights, by value
    std::vector<uint8_t> m_areReciprocals;           // by value: what is added
    std::vector<Channel> m_channels;                 // of all animations
    std::vector<size_t> m_firstChannel;              // by animation, and the end
};

}  // namespace raygraph::scene
