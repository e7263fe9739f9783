// Check: what moves a scene.
#include <algorithm>
#include <cmath>

#include "base/counted.h"
#include "renderer/scene/animation/animated_values.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/check_subject.h"

namespace raygraph::scene {
namespace {

bool Contains(const Bounds& outer, const glm::vec3& point) {
    return glm::all(glm::lessThanEqual(outer.min, point)) &&
           glm::all(glm::greaterThanEqual(outer.max, point)) && IsFinite(outer.min) && IsFinite(outer.max);
}

void CheckInfluences(const Primitive& primitive, const Subject& subject) {
    const JointInfluences& influences = primitive.influences;
    const size_t perVertex = influences.perVertex, wanted = perVertex * primitive.positions.size();
    if (influences.joints.size() != wanted || influences.weights.size() != wanted)
        subject.Fail(Text("{} and {} of {} with {} each", Counted(influences.joints.size(), "joint"),
                          Counted(influences.weights.size(), "weight"),
                          Counted(primitive.positions.size(), "position"), perVertex));
    for (size_t i = 0; i < wanted; i += perVertex) {
        double sum = 0.0;
        for (size_t k = i; k < i + perVertex; ++k) {
            const float weight = influences.weights[k];
            if (!(weight >= 0.0f))
                subject.Fail(Text("weights[{}] is {:.9g}, must not be negative", k, weight));
            sum += double{weight};
            const size_t joint = influences.joints[k];
            if (weight > 0.0f && !(joint < influences.bounds.size() &&
                                   Contains(influences.bounds[joint], primitive.positions[i / perVertex])))
                subject.Fail(Text("the bounds of joint {} are not around what it moves", joint));
            if (joint > 0 && joint >= influences.bounds.size())
                subject.Fail(
                    Text("joints[{}] is {}, there are bounds of {}", k, joint, influences.bounds.size()));
        }
        if (!(std::abs(sum - 1.0) <= 1e-4))
            subject.Fail(Text("the weights of vertex {} sum to {:.6g}, must be 1", i / perVertex, sum));
    }
}

void CheckTargets(const Primitive& primitive, size_t weightCount, const Subject& subject) {
    if (!primitive.targets.empty() && primitive.targets.size() != weightCount)
        subject.Fail(Text("{}, its mesh has {}", Counted(primitive.targets.size(), "morph target"),
                          Counted(weightCount, "weight")));
    for (const MorphTarget& target : primitive.targets) {
        subject.RequireStream("positions of a target", target.positions, primitive.positions.size());
        subject.RequireStream("normals of a target", target.normals, primitive.normals.size());
        subject.RequireStream("tangents of a target", target.tangents, primitive.tangents.size());
        subject.Require(std::ranges::all_of(target.positions,
                                            [&](const glm::vec3& p) { return Contains(target.bounds, p); }),
                        "the bounds of a target are not around its positions");
    }
}

void CheckSkin(const Skin& skin, size_t nodeCount, const Subject& subject) {
    subject.Require(!skin.joints.empty() && skin.joints.size() <= Skin::kMaxJoints,
                    "it has no joints, or too many");
    for (const uint32_t joint : skin.joints) subject.RequireIndex("a joint", joint, nodeCount);
    if (skin.inverseBinds.size() != skin.joints.size())
        subject.Fail(Text("{} of {}",
                          Counted(skin.inverseBinds.size(), "inverse bind matrix", "inverse bind matrices"),
                          Counted(skin.joints.size(), "joint")));
    subject.Require(std::ranges::all_of(skin.inverseBinds, [](const glm::mat4x3& m) { return IsFinite(m); }),
                    "an inverse bind matrix is not finite");
}

void CheckNode(const SceneData& scene, const Node& node, bool isPlaced,
               const std::vector<bool>& areSkinsPlaced, const Subject& subject) {
    subject.RequireIndex("skin", node.skin, scene.skins.size(), true);
    subject.RequireFinite("weights", node.weights);
    const size_t weightCount = node.mesh == kNone ? 0 : scene.meshes[node.mesh].weights.size();
    if (!node.weights.empty() && node.weights.size() != weightCount)
        subject.Fail(Text("{}, its mesh has {}", Counted(node.weights.size(), "weight"), weightCount));
    subject.Require(node.skin == kNone || !isPlaced || areSkinsPlaced[node.skin],
                    "a joint of its skin is not in nodeOrder");
}

// Checks the mesh of a node or an instance.
void CheckDeformedMesh(const SceneData& scene, const Node& node, uint32_t mesh,
                       const std::vector<size_t>& jointCounts, const Subject& subject) {
    if (node.skin != kNone && jointCounts[mesh] > scene.skins[node.skin].joints.size())
        subject.Fail(Text("its mesh has {}, its skin {}", Counted(jointCounts[mesh], "joint"),
                          scene.skins[node.skin].joints.size()));
    const size_t weightCount = scene.meshes[mesh].weights.size();
    if (!node.weights.empty() && node.weights.size() != weightCount)
        subject.Fail(
            Text("its node has {}, its mesh {}", Counted(node.weights.size(), "weight"), weightCount));
}

// Joint matrices go to the one object space of all instances with a skin. Those that are collapsed have
// transforms of other times, and are not seen.
void CheckSkinFrames(const SceneData& scene, const Subject& subject) {
    std::vector<const Instance*> placed(scene.skins.size(), nullptr);
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];  // whose indices are checked later
        if (!instance.isDeformed || instance.isCollapsed || instance.node >= scene.nodes.size() ||
            instance.mesh >= scene.meshes.size() || !HasSkin(scene, instance))
            continue;
        const uint32_t skin = scene.nodes[instance.node].skin;
        if (placed[skin] && (placed[skin]->objectToWorld != instance.objectToWorld ||
                             placed[skin]->translationResidual != instance.translationResidual))
            subject.In("instances", i)
                .Fail(Text("its transform is not that of instances[{}], which has the same skin",
                           placed[skin] - scene.instances.data()));
        if (!placed[skin]) placed[skin] = &instance;
    }
}

void CheckSampler(const AnimationSampler& sampler, const Subject& subject) {
    subject.Require(!sampler.times.empty() && sampler.width > 0, "it has no keys");
    subject.RequireFinite("times", sampler.times);
    subject.RequireFinite("values", sampler.values);
    subject.Require(std::ranges::adjacent_find(sampler.times, std::greater_equal<>()) == sampler.times.end(),
                    "its times do not ascend");
    const size_t parts = sampler.interpolation == Interpolation::CubicSpline ? 3 : 1;
    if (sampler.values.size() != parts * sampler.width * sampler.times.size())
        subject.Fail(Text("{} of {}, {} wide", Counted(sampler.values.size(), "value"),
                          Counted(sampler.times.size(), "key"), sampler.width));
}

void CheckRotations(const AnimationSampler& sampler, const Subject& subject) {
    const bool isCubic = sampler.interpolation == Interpolation::CubicSpline;
    for (size_t i = isCubic ? 4 : 0; i < sampler.values.size(); i += isCubic ? 12 : 4) {
        const float* const q = &sampler.values[i];
        const double square =
            double{q[0]} * q[0] + double{q[1]} * q[1] + double{q[2]} * q[2] + double{q[3]} * q[3];
        subject.Require(square > 1e-12, "a rotation of its sampler is a quaternion of length 0");
    }
}

void CheckChannels(const SceneData& scene, const Animation& animation, const Subject& subject) {
    std::vector<AnimationTarget> targets;
    std::vector<bool> areRotations(animation.samplers.size());
    for (size_t i = 0; i < animation.channels.size(); ++i) {
        const AnimationChannel& channel = animation.channels[i];
        const Subject here = subject.In("channels", i);
        here.RequireIndex("sampler", channel.sampler, animation.samplers.size());
        const AnimationSampler& sampler = animation.samplers[channel.sampler];
        const size_t width = WidthOf(scene, channel.target);
        here.Require(width > 0, "its target is nothing that the scene has");
        if (width != sampler.width)
            here.Fail(Text("its sampler is {} wide, its target {}", sampler.width, width));
        if (channel.target.property == AnimatedProperty::Rotation && !areRotations[channel.sampler]) {
            CheckRotations(sampler, here);
            areRotations[channel.sampler] = true;
        }
        targets.push_back(channel.target);
    }
    std::ranges::sort(targets);
    subject.Require(std::ranges::adjacent_find(targets) == targets.end(), "two channels have one target");
}

}  // namespace

void CheckDeformation(const SceneData& scene, const Subject& subject) {
    for (size_t i = 0; i < scene.skins.size(); ++i)
        CheckSkin(scene.skins[i], scene.nodes.size(), subject.In("skins", i));
    for (size_t i = 0; i < scene.meshes.size(); ++i) {
        subject.In("meshes", i).RequireFinite("weights", scene.meshes[i].weights);
        for (size_t p = 0; p < scene.meshes[i].primitives.size(); ++p) {
            const Primitive& primitive = scene.meshes[i].primitives[p];
            const Subject here = subject.In("meshes", i).In("primitives", p);
            here.Require(
                !primitive.IsRound() || (primitive.influences.IsEmpty() && primitive.targets.empty()),
                "round primitives have joints or morph targets");
            here.Require(!primitive.hasFlatNormals || primitive.positions.size() % 3 == 0,
                         "flat normals are of three vertices a triangle");
            CheckInfluences(primitive, here);
            CheckTargets(primitive, scene.meshes[i].weights.size(), here);
        }
    }
    std::vector<bool> isPlaced(scene.nodes.size(), false);
    for (const uint32_t node : scene.nodeOrder) isPlaced[node] = true;
    std::vector<bool> areSkinsPlaced;
    for (const Skin& skin : scene.skins)
        areSkinsPlaced.push_back(
            std::ranges::all_of(skin.joints, [&](uint32_t joint) { return bool(isPlaced[joint]); }));
    std::vector<size_t> jointCounts(scene.meshes.size());
    for (size_t i = 0; i < scene.meshes.size(); ++i)
        for (const Primitive& primitive : scene.meshes[i].primitives)
            jointCounts[i] = std::max(jointCounts[i], primitive.influences.JointCount());
    for (size_t i = 0; i < scene.nodes.size(); ++i) {
        const Node& node = scene.nodes[i];
        CheckNode(scene, node, isPlaced[i], areSkinsPlaced, subject.In("nodes", i));
        if (isPlaced[i] && node.mesh != kNone)
            CheckDeformedMesh(scene, node, node.mesh, jointCounts, subject.In("nodes", i));
    }
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];  // whose indices are checked later
        if (instance.node < scene.nodes.size() && instance.mesh < scene.meshes.size())
            CheckDeformedMesh(scene, scene.nodes[instance.node], instance.mesh, jointCounts,
                              subject.In("instances", i));
    }
    CheckSkinFrames(scene, subject);
}

void CheckAnimations(const SceneData& scene, const Subject& subject) {
    for (size_t i = 0; i < scene.animations.size(); ++i) {
        const Animation& animation = scene.animations[i];
        const Subject here = subject.In("animations", i);
        float last = 0.0f;
        for (size_t s = 0; s < animation.samplers.size(); ++s) {
            CheckSampler(animation.samplers[s], here.In("samplers", s));
            last = s == 0 ? animation.samplers[s].times.back()
                          : std::max(last, animation.samplers[s].times.back());
        }
        here.Require(animation.duration == std::max(last, 0.0f), "its duration is not its last time");
        CheckChannels(scene, animation, here);
    }
}

}  // namespace raygraph::scene
