#include "renderer/scene/gltf/still_scene.h"

#include <algorithm>
#include <map>
#include <span>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/named_choice.h"

namespace raygraph::scene {
namespace {

constexpr std::string_view kAllClips = "all";

uint32_t FindAnimation(const SceneData& scene, std::string_view choice) {
    return FindNamed(scene.animations, choice, "animation", " none",
                     [](const Animation& animation) -> const std::string& { return animation.name; });
}

// Finds one animation of the list. A name may contain a colon: the text after the last one is a weight if it
// is a number.
ClipState FindClip(const SceneData& scene, std::string_view text, double seconds) {
    ClipState clip{.seconds = seconds};
    const size_t colon = text.rfind(':');
    float weight = 1.0f;
    if (colon != text.npos && IsNumber(text.substr(colon + 1), weight)) {
        if (!(weight >= 0.0f && weight <= 1e6f))
            throw MakeError(ErrorKind::BadInput, "the weight of {} is not from 0 to 1e6", Quoted(text));
        clip.weight = weight;
        text = text.substr(0, colon);
    }
    clip.animation = FindAnimation(scene, text);
    return clip;
}

// Returns the text with which FindClip finds the clip.
std::string TextOf(const SceneData& scene, const ClipState& clip) {
    const std::string& name = scene.animations.at(clip.animation).name;
    const auto first = std::ranges::find(scene.animations, name, &Animation::name);
    const bool isFound = !name.empty() && name != kAllClips && name.find(',') == name.npos &&
                         first == scene.animations.begin() + clip.animation;
    std::string text = isFound ? name : std::to_string(clip.animation);
    float number = 0.0f;
    const size_t colon = text.rfind(':');
    const bool seemsWeighted =
        colon != text.npos && IsNumber(std::string_view(text).substr(colon + 1), number);
    if (clip.weight != 1.0f || seemsWeighted) text += Text(":{}", clip.weight);
    return text;
}

// Identifies the shape of an instance: instances of one mesh and one skin with the same weights share their
// vertices. None: the vertices are those of the mesh.
using Shape = std::tuple<uint32_t, uint32_t, std::vector<float>>;

Shape ShapeOf(const SceneData& scene, const Instance& instance) {
    const uint32_t skin = HasSkin(scene, instance) ? scene.nodes[instance.node].skin : kNone;
    const std::span<const float> weights = MorphWeights(scene, instance);
    const bool isOfMesh = std::ranges::equal(weights, scene.meshes[instance.mesh].weights);
    return {instance.mesh, skin,
            isOfMesh ? std::vector<float>() : std::vector<float>(weights.begin(), weights.end())};
}

// Returns the bytes of a copy without its deformation.
uint64_t CopyBytes(const Mesh& mesh) {
    const auto bytesOf = [](const auto& values) { return std::span(values).size_bytes(); };
    uint64_t bytes = sizeof(Mesh);
    for (const Primitive& p : mesh.primitives)
        bytes += sizeof(Primitive) + bytesOf(p.positions) + bytesOf(p.normals) + bytesOf(p.tangents) +
                 bytesOf(p.frameTurns) + bytesOf(p.uv0) + bytesOf(p.uv1) + bytesOf(p.colors) +
                 bytesOf(p.indices) + bytesOf(p.variants) + bytesOf(p.radii);
    return bytes;
}

// `from` with its vertices deformed into `to`, which may be the same; what nothing deforms stays.
void Deform(const Primitive& from, std::span<const float> weights, std::span<const glm::mat4x3> joints,
            Primitive& to) {
    const bool isMorphed = !from.targets.empty(), isMoved = !from.influences.IsEmpty() && !joints.empty();
    if (!isMorphed && !isMoved) {
        to.positions = from.positions;
        to.normals = from.normals;
        to.tangents = from.tangents;
        return;
    }
    DeformedStreams deformed;
    DeformPrimitive(from, isMorphed ? weights : std::span<const float>{},
                    isMoved ? joints : std::span<const glm::mat4x3>{}, deformed);
    to.positions = std::move(deformed.positions);
    to.normals = std::move(deformed.normals);
    to.tangents = std::move(deformed.tangents);
    to.bounds = BoundsOf(to.positions);
}

// Copies the fields that no joint and no target changes.
Primitive CopyBesideStreams(const Primitive& from) {
    Primitive copy;
    copy.tangentTexCoord = from.tangentTexCoord;
    copy.frameTurns = from.frameTurns;
    copy.uv0 = from.uv0;
    copy.uv1 = from.uv1;
    copy.colors = from.colors;
    copy.indices = from.indices;
    copy.material = from.material;
    copy.bounds = from.bounds;
    copy.variants = from.variants;
    copy.radii = from.radii;
    copy.hasFlatNormals = from.hasFlatNormals;
    return copy;
}

// Returns whether instances can move with the node. Relative to a flat node no transform would restore their
// place.
bool CanAttach(const PlacedTransform& node) {
    return !IsFlat(node.matrix) && CanInvert(node.matrix);
}

// Erases instances that are collapsed, and unseen ones that a skin places and that cannot attach to their
// node, by which they could otherwise be shown later.
void EraseInvisible(SceneData& scene, const PoseApplier& applier) {
    size_t index = 0;
    std::erase_if(scene.instances, [&](const Instance& instance) {
        const bool isSeen = applier.IsVisible(static_cast<uint32_t>(index++));
        return instance.isCollapsed || (!isSeen && instance.isDeformed && HasSkin(scene, instance) &&
                                        !CanAttach(applier.NodeTransforms()[instance.node]));
    });
}

// Makes the instance move with its node from then on, as others do. If the node is flat, the instance stays
// where it is.
void AttachToNode(Instance& instance, const PlacedTransform& node) {
    if (!CanAttach(node)) {
        instance.node = kNone;
        return;
    }
    const glm::dmat3 toNode = glm::inverse(glm::dmat3(node.matrix));
    const glm::dmat3 linear = toNode * glm::dmat3(instance.objectToWorld);
    const PlacedTransform placed{instance.objectToWorld, instance.translationResidual};
    const glm::dvec3 place = toNode * (placed.Place() - node.Place());
    instance.objectToNode = {glm::vec3(linear[0]), glm::vec3(linear[1]), glm::vec3(linear[2]),
                             glm::vec3(place)};
}

void MeasureBounds(SceneData& scene) {
    const std::vector<bool> isVisible = VisibleNodes(scene);
    scene.bounds = {};
    for (const Instance& instance : scene.instances)
        if (IsVisible(isVisible, instance))
            for (const Primitive& primitive : scene.meshes[instance.mesh].primitives)
                scene.bounds.Extend(primitive.bounds.Transformed(instance.objectToWorld));
}

}  // namespace

std::vector<ClipState> FindClips(const SceneData& scene, std::string_view list, double seconds) {
    std::vector<ClipState> clips;
    if (list == kAllClips || (list.empty() && !scene.animations.empty())) {
        const size_t count = list.empty() ? 1 : scene.animations.size();
        for (uint32_t i = 0; i < count; ++i) clips.push_back({.animation = i, .seconds = seconds});
        return clips;
    }
    while (!list.empty()) {
        const size_t comma = std::min(list.find(','), list.size());
        clips.push_back(FindClip(scene, list.substr(0, comma), seconds));
        list.remove_prefix(std::min(comma + 1, list.size()));
    }
    return clips;
}

std::string ClipsText(const SceneData& scene, std::span<const ClipState> clips) {
    const auto isWhole = [&](const ClipState& clip) {
        return clip.weight == 1.0f && clip.animation == static_cast<size_t>(&clip - clips.data());
    };
    if (clips.size() > 1 && clips.size() == scene.animations.size() && std::ranges::all_of(clips, isWhole))
        return std::string(kAllClips);
    std::string list;
    for (const ClipState& clip : clips)
        if (clip.weight > 0.0f) list += Text("{}{}", list.empty() ? "" : ",", TextOf(scene, clip));
    return list;
}

namespace {

// Gives the instances meshes that are deformed. A shape takes the place of its mesh where nothing else shows
// that; all others are copies.
void DeformMeshes(SceneData& scene, const PoseApplier& applier, uint64_t maxCopiedBytes) {
    std::map<Shape, uint32_t> meshes;  // deformed ones, by index
    std::vector<bool> isTaken(scene.meshes.size());
    for (const Instance& instance : scene.instances)
        if (!instance.isDeformed) isTaken[instance.mesh] = true;
    std::vector<uint32_t> meshOf;
    size_t meshCount = scene.meshes.size();
    uint64_t copiedBytes = 0;
    for (const Instance& instance : scene.instances) {
        meshOf.push_back(instance.mesh);
        if (!instance.isDeformed) continue;
        const auto [found, isNew] = meshes.try_emplace(ShapeOf(scene, instance), instance.mesh);
        if (isNew && isTaken[instance.mesh]) {
            const Mesh& mesh = scene.meshes[instance.mesh];
            copiedBytes += CopyBytes(mesh);
            if (copiedBytes > maxCopiedBytes)
                throw MakeError(ErrorKind::BadInput,
                                "meshes[{}] {}: deformed copies of meshes take more than {} bytes",
                                instance.mesh, Quoted(mesh.name, 60), maxCopiedBytes);
            found->second = static_cast<uint32_t>(meshCount++);
        }
        isTaken[instance.mesh] = true;
        meshOf.back() = found->second;
    }
    const size_t sourceCount = scene.meshes.size();
    scene.meshes.resize(meshCount);
    for (const bool isCopy : {true, false})  // copies first, of the shape at rest
        for (const auto& [shape, index] : meshes) {
            if ((index >= sourceCount) != isCopy) continue;
            const auto& [source, skin, own] = shape;
            const Mesh& from = scene.meshes[source];
            const std::span<const float> weights = own.empty() ? from.weights : own;
            const auto joints =
                skin == kNone ? std::span<const glm::mat4x3>{} : applier.JointMatricesOf(skin);
            Mesh& to = scene.meshes[index];
            to.name = from.name;
            for (size_t i = 0; i < from.primitives.size(); ++i) {
                if (isCopy) to.primitives.push_back(CopyBesideStreams(from.primitives[i]));
                Deform(from.primitives[i], weights, joints, to.primitives[i]);
            }
        }
    for (size_t i = 0; i < meshOf.size(); ++i) scene.instances[i].mesh = meshOf[i];
}

void Freeze(SceneData& scene, std::span<const ClipState> clips, uint64_t maxCopiedBytes) {
    if (scene.animations.empty() && scene.skins.empty() &&
        std::ranges::none_of(scene.instances, [&](const Instance& i) { return HasTargets(scene, i); }))
        return;
    PoseEvaluator evaluator(scene);
    PoseApplier applier(scene);
    applier.Apply(scene, evaluator.Evaluate(scene, clips));
    EraseInvisible(scene, applier);
    std::vector<bool> isSkinned;  // which copies of meshes do not tell
    for (const Instance& instance : scene.instances)
        isSkinned.push_back(instance.isDeformed && HasSkin(scene, instance));
    DeformMeshes(scene, applier, maxCopiedBytes);
    for (size_t i = 0; i < isSkinned.size(); ++i)
        if (isSkinned[i]) AttachToNode(scene.instances[i], applier.NodeTransforms()[scene.instances[i].node]);
    for (Instance& instance : scene.instances) instance.isDeformed = false;
    for (Mesh& mesh : scene.meshes) {
        mesh.weights.clear();
        for (Primitive& primitive : mesh.primitives) {
            primitive.influences = {};
            primitive.targets.clear();
        }
    }
    for (Node& node : scene.nodes) {
        node.skin = kNone;
        node.weights.clear();
    }
    scene.skins.clear();
    scene.animations.clear();
    MeasureBounds(scene);
}

}  // namespace

void FreezePose(SceneData& scene, std::span<const ClipState> clips, uint64_t maxCopiedBytes) {
    WithMemoryErrors("a pose of the scene", [&] { Freeze(scene, clips, maxCopiedBytes); });
}

}  // namespace raygraph::scene
