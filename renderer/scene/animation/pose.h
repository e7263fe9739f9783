// The pose of a scene at a time: PoseEvaluator computes a Pose from the clips of animations, and PoseApplier
// gives the scene its values.
//
//   scene::PoseEvaluator evaluator(data);                     // keeps the rest pose
//   scene::PoseApplier applier(data);
//   for (;;) {
//       const scene::Pose& pose = evaluator.Evaluate(data, std::array{scene::ClipState{walk, seconds}});
//       Upload(applier.Apply(data, pose));                    // what has changed, as lists of indices
//   }
//
// Threads: exclusive access to an evaluator, which only reads the scene, and to an applier with its scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "base/api.h"
#include "renderer/scene/geometry/bounds_tree.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// An animation that plays, at a time and with a weight. Before its first key a property has the value of the
// first key, after its last key that of the last. For a loop, take the time modulo Animation::duration.
struct ClipState {
    uint32_t animation = 0;  // index into SceneData::animations
    double seconds = 0.0;
    float weight = 1.0f;  // 0 or less: as if it were not there.

    bool operator==(const ClipState&) const = default;
};

// Throws Error{BadInput} with Animation::defect if one of the clips that has a weight is of an animation with
// a defect, and Error{Usage} if there is no such animation.
RAYGRAPH_API void RequirePlayable(const SceneData& scene, std::span<const ClipState> clips);

// Describes a property that some animation of the scene changes, and where its value is in Pose::values.
struct PosedProperty {
    AnimationTarget target;  // a whole: of weights all
    size_t first = 0;
    size_t count = 0;
};

// Holds the values of all that any animation of the scene changes, whether or not a clip does now, and of
// what has to be kept legal beside it (a spot's inner cone angle beside the outer one): what none changes has
// its rest value. Numbers are not yet in the range of their field; rotations are x, y, z, w of unit length;
// flags are their share, of which half is true.
struct Pose {
    std::vector<PosedProperty>
        properties;  // in the order of their targets; the same in every pose of a scene
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

// --- Applying a pose, and saying what has changed, so that a copy of the scene elsewhere can follow ---

// The changes of a call: indices, each once, ascending. The values are in the scene, or those of the applier.
struct PoseChanges {
    std::vector<uint32_t> instances;   // objectToWorld, translationResidual
    std::vector<uint32_t> shown;       // instances that are seen now and were not, or the other way
    std::vector<uint32_t> deformed;    // instances whose vertices have moved in object space:
    std::vector<uint32_t> reweighted;  // those whose MorphWeights, and
    std::vector<uint32_t> skins;       // skins that have other JointMatricesOf.
    std::vector<uint32_t> materials;
    std::vector<uint32_t> cameras;      // a value or the transform
    std::vector<uint32_t> lights;       // a value or the transform
    std::vector<uint32_t> lightsShown;  // as `shown`
    bool areBoundsChanged = false;      // SceneData::bounds

    bool IsEmpty() const {
        return instances.empty() && shown.empty() && deformed.empty() && materials.empty() &&
               cameras.empty() && lights.empty() && lightsShown.empty() && !areBoundsChanged;
    }
};

// Returns a copy of a scene without vertices, images, environment and light profiles: enough to be posed.
RAYGRAPH_API SceneData PoseOutline(const SceneData& scene);

class RAYGRAPH_API PoseApplier {
  public:
    // Calls DeformInstances(scene). Later calls are to be given this scene, or a copy of it that is kept
    // equal; its vertices may be missing, but not JointInfluences::perVertex and the boxes.
    explicit PoseApplier(SceneData& scene);

    // Reads all transforms and visibilities from the scene's nodes again, after others have changed nodes or
    // the lists of the scene. It reports no changes: copies elsewhere must take everything.
    void Refresh(SceneData& scene);

    // Sets the values of the pose, in the range of their fields, then what follows from the nodes:
    // transforms of instances, cameras and lights as UpdateWorldTransforms sets them, joint matrices,
    // visibility and the scene's bounds, of deformed instances by DeformedBounds. An instance that is scaled
    // to nothing or to a line, or whose deformation is not finite, is not seen (Instance::isCollapsed); the
    // former keeps its last transform. `edited` lists nodes whose local transform or visibility others have
    // changed since the last call; what depends on these is updated, too. The time is proportional to what
    // has changed, plus a few bytes read for each node, instance and property. The result is valid until the
    // next call. No memory is allocated once the lists have grown.
    const PoseChanges& Apply(SceneData& scene, const Pose& pose, std::span<const uint32_t> edited = {});

    // Returns one matrix for each joint, from the mesh to the object space of the instances with the skin;
    // none for a skin that no deformed instance has.
    std::span<const glm::mat4x3> JointMatricesOf(uint32_t skin) const;
    // Returns whether the nodes of an instance are visible, and it is not collapsed.
    bool IsVisible(uint32_t instance) const { return m_isInstanceVisible[instance] != 0; }
    bool IsLightVisible(uint32_t light) const { return m_isLightVisible[light] != 0; }
    // Returns whether the node and all above it are visible; false for one that is not in nodeOrder, which
    // an editor has removed: what it places is not visible either.
    bool IsNodeVisible(uint32_t node) const { return m_isNodeVisible[node] != 0; }
    // Returns the bounds of an instance in world space, whether or not it is visible.
    const Bounds& BoundsOf(uint32_t instance) const { return m_instanceBounds[instance]; }
    std::span<const PlacedTransform> NodeTransforms() const { return m_nodeToWorld; }

  private:
    struct PosedSkin {
        PlacedTransform frame;
        size_t firstMatrix = 0, jointCount = 0;
        bool isUsed = false, isMoved = false, isDeformed = false;  // the last two: by this call
    };

    bool SetValues(SceneData& scene, const Pose& pose);
    void MoveNodes(const SceneData& scene);
    void MoveSkins(const SceneData& scene);
    void MoveInstances(SceneData& scene);
    void MoveCamerasAndLights(SceneData& scene);
    void UpdateVisibility(const SceneData& scene);
    void UpdateBounds(SceneData& scene);
    void StoreBounds(SceneData& scene);
    Bounds BoundsIfVisible(uint32_t instance) const {
        return m_isInstanceVisible[instance] ? m_instanceBounds[instance] : Bounds();
    }
    bool MeasureInstance(const SceneData& scene, uint32_t index);
    PlacedTransform PlacedTransformOf(const SceneData& scene, const Instance& instance) const;
    const PosedSkin* SkinOf(const SceneData& scene, const Instance& instance) const;

    PoseChanges m_changes;
    std::vector<PlacedTransform> m_nodeToWorld;
    std::vector<uint8_t> m_isMoved, m_isReweighted;  // by node, in this call
    std::vector<uint8_t> m_isMeshReweighted;         // indexed by mesh
    std::vector<uint8_t> m_isNodeVisible, m_isInstanceVisible, m_isLightVisible;
    std::vector<uint8_t> m_isSkinned, m_hasNoArea;  // by instance; m_hasNoArea depends on its transform alone
    // Copies of the fields that every call reads of each object, so that it reads few bytes.
    std::vector<uint32_t> m_parents;        // indexed by node
    std::vector<uint32_t> m_instanceNodes;  // indexed by instance
    std::vector<uint8_t> m_isDeformed;      // indexed by instance
    std::vector<size_t> m_followers;        // indexed by property
    std::vector<Bounds> m_instanceBounds;
    BoundsTree m_visibleBounds;  // of instances that are seen
    std::vector<PosedSkin> m_skins;
    std::vector<glm::mat4x3> m_matrices, m_newMatrices;
    bool m_isVisibilityChanged = false;
};

}  // namespace raygraph::scene
