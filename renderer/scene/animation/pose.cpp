#include "renderer/scene/animation/pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "renderer/scene/animation/animated_values.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/model/check.h"

namespace raygraph::scene {
namespace {

AnimationTarget Whole(AnimationTarget target) {
    if (IsMorphWeights(target)) target.element = kNone;
    return target;
}

bool IsTransform(const AnimationTarget& target) {
    return target.property == AnimatedProperty::Translation ||
           target.property == AnimatedProperty::Rotation || target.property == AnimatedProperty::Scale;
}

bool IsIgnored(const SceneData& scene, const AnimationTarget& target) {
    return WidthOf(scene, target) == 0 || (IsTransform(target) && scene.nodes[target.object].matrix);
}

bool Plays(const ClipState& clip) {
    return clip.weight > 0.0f && std::isfinite(clip.weight);
}

// Returns the dot product of two quaternions.
double Dot(const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

// Converts a value to its reciprocal and back. Infinite is 0 on either side.
double Reciprocal(double value) {
    return value == 0.0 ? 0.0 : 1.0 / value;
}

}  // namespace

PoseEvaluator::PoseEvaluator(const SceneData& scene) {
    std::vector<AnimationTarget> targets;
    for (const Animation& animation : scene.animations)
        for (const AnimationChannel& channel : animation.channels)
            if (!IsIgnored(scene, channel.target)) {
                targets.push_back(Whole(channel.target));
                if (const auto follower = DependentOf(channel.target)) targets.push_back(*follower);
            }
    std::ranges::sort(targets);
    targets.erase(std::unique(targets.begin(), targets.end()), targets.end());

    size_t valueCount = 0, widest = 0;
    for (const AnimationTarget& target : targets) {
        const size_t width = WidthOf(scene, target);
        m_pose.properties.push_back({target, valueCount, width});
        valueCount += width;
        m_areReciprocals.resize(valueCount, IsInfiniteAtZero(target) ? 1 : 0);
        widest = std::max(widest, width);
    }
    m_pose.values.resize(valueCount);
    m_totals.resize(valueCount);
    m_rest.resize(valueCount);
    m_sample.resize(widest);
    ReadRest(scene);

    for (const Animation& animation : scene.animations) {
        m_firstChannel.push_back(m_channels.size());
        for (const AnimationChannel& channel : animation.channels) {
            if (IsIgnored(scene, channel.target)) continue;
            const auto at = std::ranges::lower_bound(targets, Whole(channel.target));
            size_t first = m_pose.properties[static_cast<size_t>(at - targets.begin())].first;
            const bool isOneWeight = IsMorphWeights(channel.target) && channel.target.element != kNone;
            if (isOneWeight) first += channel.target.element;
            m_channels.push_back({.sampler = channel.sampler,
                                  .first = first,
                                  .isRotation = channel.target.property == AnimatedProperty::Rotation});
        }
    }
    m_firstChannel.push_back(m_channels.size());
    Rest();
}

void PoseEvaluator::ReadRest(const SceneData& scene) {
    for (const PosedProperty& property : m_pose.properties)
        GetValue(scene, property.target, &m_rest[property.first]);
}

void RequirePlayable(const SceneData& scene, std::span<const ClipState> clips) {
    for (const ClipState& clip : clips) {
        if (clip.animation >= scene.animations.size())
            throw MakeError(ErrorKind::Usage, "there is no animation {}, the scene has {}", clip.animation,
                            scene.animations.size());
        const std::string& defect = scene.animations[clip.animation].defect;
        if (Plays(clip) && !defect.empty()) throw Error(ErrorKind::BadInput, defect);
    }
}

const Pose& PoseEvaluator::Rest() {
    m_pose.values = m_rest;
    return m_pose;
}

const Pose& PoseEvaluator::Evaluate(const SceneData& scene, std::span<const ClipState> clips) {
    RG_CHECK_EQ(scene.animations.size() + 1, m_firstChannel.size());
    RequirePlayable(scene, clips);
    std::ranges::fill(m_pose.values, 0.0);
    std::ranges::fill(m_totals, 0.0);
    for (const ClipState& clip : clips) {
        if (!Plays(clip)) continue;
        const Animation& animation = scene.animations[clip.animation];
        for (size_t i = m_firstChannel[clip.animation]; i < m_firstChannel[clip.animation + size_t{1}]; ++i)
            Add(animation.samplers[m_channels[i].sampler], m_channels[i], clip.seconds, double{clip.weight});
    }
    for (const PosedProperty& property : m_pose.properties) Finish(property);
    return m_pose;
}

void PoseEvaluator::Add(const AnimationSampler& sampler, Channel& channel, double seconds, double weight) {
    SampleAnimation(sampler, seconds, channel.isRotation, channel.interval, m_sample.data());
    double* const sum = &m_pose.values[channel.first];
    const bool isTurned = channel.isRotation && Dot(sum, m_sample.data()) < 0.0;
    for (size_t i = 0; i < sampler.width; ++i) {
        const double sample = m_areReciprocals[channel.first + i] ? Reciprocal(m_sample[i]) : m_sample[i];
        sum[i] += (isTurned ? -weight : weight) * sample;
        m_totals[channel.first + i] += weight;
    }
}

void PoseEvaluator::Finish(const PosedProperty& property) {
    double* const sum = &m_pose.values[property.first];
    const double *const total = &m_totals[property.first], *const rest = &m_rest[property.first];
    const bool isRotation = property.target.property == AnimatedProperty::Rotation;
    const bool isTurned = isRotation && Dot(sum, rest) < 0.0;
    for (size_t i = 0; i < property.count; ++i) {
        const bool isReciprocal = m_areReciprocals[property.first + i] != 0;
        if (total[i] == 0.0) {
            sum[i] = rest[i];
            continue;
        }
        if (total[i] < 1.0)
            sum[i] +=
                (isTurned ? total[i] - 1.0 : 1.0 - total[i]) * (isReciprocal ? Reciprocal(rest[i]) : rest[i]);
        else if (total[i] > 1.0)
            sum[i] /= total[i];
        if (isReciprocal) sum[i] = Reciprocal(sum[i]);
    }
    if (!isRotation || total[0] == 0.0) return;
    const double length = std::sqrt(Dot(sum, sum));
    for (size_t i = 0; i < 4; ++i) sum[i] = length > 1e-9 ? sum[i] / length : rest[i];
}

// --- Applying a pose ---

namespace {

void MakeUnique(std::vector<uint32_t>& indices) {
    std::ranges::sort(indices);
    indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
}

bool IsIn(const std::vector<uint8_t>& flags, uint32_t node) {
    return node != kNone && flags[node] != 0;
}

// Returns whether the flag was another one.
bool Replace(uint8_t& flag, bool value) {
    return std::exchange(flag, uint8_t{value}) != uint8_t{value};
}

void Clear(PoseChanges& changes) {
    auto& [instances, shown, deformed, reweighted, skins, materials, cameras, lights, lightsShown,
           areBounds] = changes;
    for (std::vector<uint32_t>* list :
         {&instances, &shown, &deformed, &reweighted, &skins, &materials, &cameras, &lights, &lightsShown})
        list->clear();
    areBounds = false;
}

}  // namespace

SceneData PoseOutline(const SceneData& scene) {
    SceneData outline;
    outline.name = scene.name;
    for (const Mesh& mesh : scene.meshes) {
        Mesh& kept = outline.meshes.emplace_back();
        kept.name = mesh.name;
        kept.weights = mesh.weights;
        for (const Primitive& primitive : mesh.primitives) {
            Primitive& part = kept.primitives.emplace_back();
            part.material = primitive.material;
            part.bounds = primitive.bounds;
            part.variants = primitive.variants;
            part.influences.perVertex = primitive.influences.perVertex;
            part.influences.bounds = primitive.influences.bounds;
            part.hasFlatNormals = primitive.hasFlatNormals;
            for (const MorphTarget& target : primitive.targets)
                part.targets.emplace_back().bounds = target.bounds;
        }
    }
    outline.materials = scene.materials;
    outline.nodes = scene.nodes;
    outline.nodeOrder = scene.nodeOrder;
    outline.otherScenes = scene.otherScenes;
    outline.instances = scene.instances;
    outline.cameras = scene.cameras;
    outline.lights = scene.lights;
    outline.bounds = scene.bounds;
    outline.variants = scene.variants;
    outline.variant = scene.variant;
    outline.skins = scene.skins;
    outline.animations = scene.animations;
    return outline;
}

PoseApplier::PoseApplier(SceneData& scene) {
    Refresh(scene);
}

void PoseApplier::Refresh(SceneData& scene) {
    DeformInstances(scene);
    m_nodeToWorld = WorldTransforms(scene);
    m_isMoved.assign(scene.nodes.size(), 0);
    m_isReweighted.assign(scene.nodes.size(), 0);
    m_isMeshReweighted.assign(scene.meshes.size(), 0);
    m_isSkinned.assign(scene.instances.size(), 0);
    m_skins.assign(scene.skins.size(), {});
    m_matrices.clear();
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        if (!HasSkin(scene, scene.instances[i])) continue;
        m_isSkinned[i] = 1;
        m_skins[scene.nodes[scene.instances[i].node].skin].isUsed = true;
    }
    for (size_t i = 0; i < m_skins.size(); ++i) {
        PosedSkin& skin = m_skins[i];
        if (!skin.isUsed) continue;
        skin.firstMatrix = m_matrices.size();
        skin.jointCount = scene.skins[i].joints.size();
        skin.frame = SkinFrame(m_nodeToWorld, scene.skins[i]);
        m_matrices.resize(m_matrices.size() + scene.skins[i].joints.size());
        JointMatrices(m_nodeToWorld, scene.skins[i], skin.frame,
                      std::span(m_matrices).subspan(skin.firstMatrix));
    }
    m_isNodeVisible.assign(scene.nodes.size(), 0);  // until nodeOrder lists it
    m_isInstanceVisible.assign(scene.instances.size(), 1);
    m_isLightVisible.assign(scene.lights.size(), 1);
    m_isVisibilityChanged = true;
    UpdateVisibility(scene);
    m_parents.resize(scene.nodes.size());
    for (size_t i = 0; i < scene.nodes.size(); ++i) m_parents[i] = scene.nodes[i].parent;
    m_instanceNodes.resize(scene.instances.size());
    m_isDeformed.resize(scene.instances.size());
    m_visibleBounds.Assign(scene.instances.size());
    m_instanceBounds.assign(scene.instances.size(), {});
    m_hasNoArea.assign(scene.instances.size(), 0);
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        if (instance.isCollapsed && instance.node != kNone)
            m_hasNoArea[i] = WithThickness(scene, instance, PlacedTransformOf(scene, instance)) ? 0 : 1;
        MeasureInstance(scene, i);
        m_instanceNodes[i] = instance.node;
        m_isDeformed[i] = instance.isDeformed ? 1 : 0;
        m_visibleBounds.SetLeaf(i, BoundsIfVisible(i));
    }
    m_visibleBounds.Update();
    StoreBounds(scene);
    Clear(m_changes);
}

const PoseChanges& PoseApplier::Apply(SceneData& scene, const Pose& pose, std::span<const uint32_t> edited) {
    RG_CHECK_EQ(scene.nodes.size(), m_nodeToWorld.size());
    RG_CHECK_EQ(scene.instances.size(), m_isInstanceVisible.size());
    Clear(m_changes);
    std::ranges::fill(m_isMoved, uint8_t{0});
    std::ranges::fill(m_isReweighted, uint8_t{0});
    std::ranges::fill(m_isMeshReweighted, uint8_t{0});
    m_isVisibilityChanged = !edited.empty();
    for (PosedSkin& skin : m_skins) skin.isMoved = skin.isDeformed = false;
    for (const uint32_t node : edited) m_isMoved[node] = 1;
    if (SetValues(scene, pose) || !edited.empty()) {
        MoveNodes(scene);
        MoveSkins(scene);
        MoveCamerasAndLights(scene);
    }
    MoveInstances(scene);
    UpdateVisibility(scene);
    UpdateBounds(scene);
    MakeUnique(m_changes.materials);
    MakeUnique(m_changes.cameras);
    MakeUnique(m_changes.lights);
    return m_changes;
}

std::span<const glm::mat4x3> PoseApplier::JointMatricesOf(uint32_t skin) const {
    if (skin >= m_skins.size() || !m_skins[skin].isUsed) return {};
    return std::span(m_matrices).subspan(m_skins[skin].firstMatrix, m_skins[skin].jointCount);
}

// Returns whether nodes are at other places. What else follows from the values is noted.
bool PoseApplier::SetValues(SceneData& scene, const Pose& pose) {
    m_followers.clear();
    bool hasAnyMoved = false;
    const auto set = [&](const PosedProperty& property) {
        const uint32_t object = property.target.object;
        if (!SetValue(scene, property.target, &pose.values[property.first])) return;
        switch (property.target.property) {
            case AnimatedProperty::Translation:
            case AnimatedProperty::Rotation:
            case AnimatedProperty::Scale:
                m_isMoved[object] = 1;
                hasAnyMoved = true;
                break;
            case AnimatedProperty::Weights:
                m_isReweighted[object] = 1;
                break;
            case AnimatedProperty::MeshWeights:
                m_isMeshReweighted[object] = 1;
                break;
            case AnimatedProperty::Visibility:
                m_isVisibilityChanged = true;
                break;
            case AnimatedProperty::MaterialField:
            case AnimatedProperty::TextureTransform:
                m_changes.materials.push_back(object);
                break;
            case AnimatedProperty::CameraField:
                m_changes.cameras.push_back(object);
                break;
            case AnimatedProperty::LightField:
                m_changes.lights.push_back(object);
                break;
        }
    };
    for (size_t i = 0; i < pose.properties.size(); ++i) {
        if (IsDependent(pose.properties[i].target))
            m_followers.push_back(i);
        else
            set(pose.properties[i]);
    }
    for (const size_t follower : m_followers) set(pose.properties[follower]);
    return hasAnyMoved;
}

// Fills in m_isMoved, also of what is below a node that was moved.
void PoseApplier::MoveNodes(const SceneData& scene) {
    for (const uint32_t index : scene.nodeOrder) {
        if (!m_isMoved[index] && !IsIn(m_isMoved, m_parents[index])) continue;
        const Node& node = scene.nodes[index];
        const PlacedTransform local{node.LocalTransform(), node.translationResidual};
        m_nodeToWorld[index] = node.parent == kNone ? local : Compose(m_nodeToWorld[node.parent], local);
        m_isMoved[index] = 1;
    }
}

void PoseApplier::MoveSkins(const SceneData& scene) {
    for (size_t i = 0; i < m_skins.size(); ++i) {
        PosedSkin& skin = m_skins[i];
        const Skin& source = scene.skins[i];
        if (!skin.isUsed) continue;
        if (std::ranges::none_of(source.joints, [&](uint32_t joint) { return m_isMoved[joint] != 0; }))
            continue;
        const PlacedTransform frame = SkinFrame(m_nodeToWorld, source);
        skin.isMoved = !(frame == skin.frame);
        skin.frame = frame;
        m_newMatrices.resize(source.joints.size());
        JointMatrices(m_nodeToWorld, source, frame, m_newMatrices);
        const std::span<glm::mat4x3> matrices =
            std::span(m_matrices).subspan(skin.firstMatrix, source.joints.size());
        skin.isDeformed = !std::ranges::equal(matrices, m_newMatrices);
        if (!skin.isDeformed) continue;
        std::ranges::copy(m_newMatrices, matrices.begin());
        m_changes.skins.push_back(static_cast<uint32_t>(i));
    }
}

const PoseApplier::PosedSkin* PoseApplier::SkinOf(const SceneData& scene, const Instance& instance) const {
    const auto index = static_cast<size_t>(&instance - scene.instances.data());
    return m_isSkinned[index] ? &m_skins[scene.nodes[instance.node].skin] : nullptr;
}

PlacedTransform PoseApplier::PlacedTransformOf(const SceneData& scene, const Instance& instance) const {
    const PosedSkin* const skin = SkinOf(scene, instance);
    return skin ? skin->frame : PlaceInstance(m_nodeToWorld[instance.node], instance);
}

void PoseApplier::MoveInstances(SceneData& scene) {
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        if (!m_isDeformed[i] && !IsIn(m_isMoved, m_instanceNodes[i])) continue;
        Instance& instance = scene.instances[i];
        const bool isOfMesh = instance.node == kNone || scene.nodes[instance.node].weights.empty();
        const PosedSkin* const skin = SkinOf(scene, instance);
        const bool isReweighted =
            instance.isDeformed &&
            (IsIn(m_isReweighted, instance.node) || (isOfMesh && m_isMeshReweighted[instance.mesh] != 0));
        const bool isDeformed = isReweighted || (skin && skin->isDeformed);
        const bool mayMove = skin ? skin->isMoved : IsIn(m_isMoved, instance.node);
        if (isReweighted) m_changes.reweighted.push_back(i);
        if (isDeformed) m_changes.deformed.push_back(i);
        if (mayMove) {
            const std::optional<PlacedTransform> shown =
                WithThickness(scene, instance, PlacedTransformOf(scene, instance));
            m_hasNoArea[i] = shown ? 0 : 1;
            const PlacedTransform before{instance.objectToWorld, instance.translationResidual};
            if (shown && !(*shown == before)) {
                instance.objectToWorld = shown->matrix;
                instance.translationResidual = shown->rest;
                m_changes.instances.push_back(i);
            }
        }
        if (!isDeformed && !mayMove) continue;
        const bool isCollapsed = !MeasureInstance(scene, i) || m_hasNoArea[i];
        m_isVisibilityChanged |= isCollapsed != instance.isCollapsed;
        instance.isCollapsed = isCollapsed;
    }
}

void PoseApplier::MoveCamerasAndLights(SceneData& scene) {
    const auto move = [&](uint32_t node, glm::mat4x3& matrix, glm::vec3& rest) {
        if (!IsIn(m_isMoved, node)) return false;
        const PlacedTransform placed = WithDirections(scene, node, m_nodeToWorld[node]);
        if (!IsFinite(placed.matrix) || !IsFinite(placed.rest)) return false;
        if (placed == PlacedTransform{matrix, rest}) return false;
        matrix = placed.matrix;
        rest = placed.rest;
        return true;
    };
    for (uint32_t i = 0; i < scene.cameras.size(); ++i)
        if (Camera& camera = scene.cameras[i];
            move(camera.node, camera.cameraToWorld, camera.translationResidual))
            m_changes.cameras.push_back(i);
    for (uint32_t i = 0; i < scene.lights.size(); ++i)
        if (Light& light = scene.lights[i]; move(light.node, light.lightToWorld, light.translationResidual))
            m_changes.lights.push_back(i);
}

void PoseApplier::UpdateVisibility(const SceneData& scene) {
    if (!m_isVisibilityChanged) return;
    for (const uint32_t node : scene.nodeOrder) {
        const uint32_t parent = scene.nodes[node].parent;
        m_isNodeVisible[node] =
            scene.nodes[node].isVisible && (parent == kNone || m_isNodeVisible[parent]) ? 1 : 0;
    }
    const auto isSeen = [&](uint32_t node) { return node == kNone || m_isNodeVisible[node]; };
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        if (Replace(m_isInstanceVisible[i], isSeen(instance.node) && !instance.isCollapsed))
            m_changes.shown.push_back(i);
    }
    for (uint32_t i = 0; i < scene.lights.size(); ++i)
        if (Replace(m_isLightVisible[i], isSeen(scene.lights[i].node))) m_changes.lightsShown.push_back(i);
}

// Measures the box of one instance in the world. Returns false if it is deformed, and its vertices may be at
// no place.
bool PoseApplier::MeasureInstance(const SceneData& scene, uint32_t index) {
    const Instance& instance = scene.instances[index];
    const std::span<const float> weights =
        instance.isDeformed ? MorphWeights(scene, instance) : std::span<const float>();
    std::span<const glm::mat4x3> matrices;
    if (m_isSkinned[index]) matrices = JointMatricesOf(scene.nodes[instance.node].skin);
    Bounds bounds;
    for (const Primitive& primitive : scene.meshes[instance.mesh].primitives)
        bounds.Extend(DeformedBounds(primitive, weights, matrices));
    const Bounds placed = bounds.Transformed(instance.objectToWorld);
    const bool isFinite =
        IsFinite(bounds.min) && IsFinite(bounds.max) && IsFinite(placed.min) && IsFinite(placed.max);
    m_instanceBounds[index] = isFinite ? placed : Bounds();
    return isFinite || bounds.IsEmpty() || !instance.isDeformed;
}

void PoseApplier::UpdateBounds(SceneData& scene) {
    const std::array lists{&m_changes.instances, &m_changes.shown, &m_changes.deformed};
    size_t count = 0;
    for (const std::vector<uint32_t>* list : lists) count += list->size();
    if (count == 0) return;
    constexpr size_t kFew = 32;  // as a share of all: more are cheaper at once
    const bool updatesEach = count < m_visibleBounds.Count() / kFew;
    for (const std::vector<uint32_t>* list : lists) {
        for (const uint32_t i : *list) {
            if (updatesEach)
                m_visibleBounds.Set(i, BoundsIfVisible(i));
            else
                m_visibleBounds.SetLeaf(i, BoundsIfVisible(i));
        }
    }
    if (!updatesEach) m_visibleBounds.Update();
    StoreBounds(scene);
}

void PoseApplier::StoreBounds(SceneData& scene) {
    const Bounds bounds = m_visibleBounds.All();
    if (bounds.min == scene.bounds.min && bounds.max == scene.bounds.max) return;
    scene.bounds = bounds;
    m_changes.areBoundsChanged = true;
}

}  // namespace raygraph::scene
