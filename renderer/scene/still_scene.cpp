#include "renderer/scene/still_scene.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <tuple>
#include <utility>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/check.h"
#include "renderer/scene/deform.h"
#include "renderer/scene/pose_applier.h"

namespace raygraph::scene {
namespace {

// " 0 'walk', 1 'run'", as far as they fit a line.
std::string Listed(const std::vector<Animation>& animations) {
    constexpr size_t kMaxListed = 20, kMaxNameBytes = 60;
    std::string list;
    for (size_t i = 0; i < animations.size() && i < kMaxListed; ++i)
        list += Text("{} {} {}", i == 0 ? "" : ",", i, Quoted(animations[i].name, kMaxNameBytes));
    if (animations.size() > kMaxListed) list += Text(" and {} more", animations.size() - kMaxListed);
    return animations.empty() ? " none" : list;
}

template <typename Number>
bool IsNumber(std::string_view text, Number& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size();
}

uint32_t FindAnimation(const SceneData& scene, std::string_view choice) {
    for (uint32_t i = 0; i < scene.animations.size(); ++i)
        if (scene.animations[i].name == choice && !choice.empty()) return i;
    uint32_t index = 0;
    if (IsNumber(choice, index) && index < scene.animations.size()) return index;
    throw MakeError(ErrorKind::BadInput, "there is no animation {}; the scene has{}", Quoted(choice),
                    Listed(scene.animations));
}

// One of the list. A name may contain a colon: what follows the last one is a weight if it is a number.
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

// Which vertices an instance has: of one mesh, one skin and the same weights.
using Shape = std::tuple<uint32_t, uint32_t, std::vector<float>>;

void Deform(Primitive& primitive, std::span<const float> weights, std::span<const glm::mat4x3> joints) {
    DeformedStreams deformed;
    DeformPrimitive(primitive, primitive.targets.empty() ? std::span<const float>{} : weights,
                    primitive.influences.IsEmpty() ? std::span<const glm::mat4x3>{} : joints, deformed);
    primitive.positions = std::move(deformed.positions);
    primitive.normals = std::move(deformed.normals);
    primitive.tangents = std::move(deformed.tangents);
    primitive.bounds = {};
    for (const glm::vec3& position : primitive.positions) primitive.bounds.Extend(position);
}

// So that the instance moves with its node from now on, as others do. One whose node is flat stays where it
// is.
void AttachToNode(Instance& instance, const PlacedTransform& node) {
    if (!CanInvert(node.matrix)) {
        instance.node = kNone;
        return;
    }
    const glm::dmat3 toNode = glm::inverse(glm::dmat3(node.matrix));
    const glm::dmat3 linear = toNode * glm::dmat3(instance.objectToWorld);
    const PlacedTransform placed{instance.objectToWorld, instance.translationRest};
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
    if (list == "all" || (list.empty() && !scene.animations.empty())) {
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

void FreezePose(SceneData& scene, std::span<const ClipState> clips) {
    if (scene.animations.empty() && scene.skins.empty() &&
        std::ranges::none_of(scene.instances, [&](const Instance& i) { return HasTargets(scene, i); }))
        return;
    PoseEvaluator evaluator(scene);
    PoseApplier applier(scene);
    applier.Apply(scene, evaluator.Evaluate(scene, clips));

    // Shapes, by the mesh that they are of: the first takes its place, where nothing shows it as it is
    std::map<Shape, uint32_t> meshes;  // deformed ones, by index
    std::vector<bool> isTaken(scene.meshes.size());
    for (const Instance& instance : scene.instances)
        if (!instance.isDeformed) isTaken[instance.mesh] = true;
    std::vector<std::pair<Shape, uint32_t>> toDeform;
    std::vector<uint32_t> meshOf;
    for (const Instance& instance : scene.instances) {
        meshOf.push_back(instance.mesh);
        if (!instance.isDeformed) continue;
        const uint32_t skin = HasSkin(scene, instance) ? scene.nodes[instance.node].skin : kNone;
        const std::span<const float> weights = MorphWeights(scene, instance);
        Shape shape{instance.mesh, skin, {weights.begin(), weights.end()}};
        const auto [found, isNew] = meshes.try_emplace(shape, instance.mesh);
        if (isNew) {
            if (isTaken[instance.mesh]) {
                found->second = static_cast<uint32_t>(scene.meshes.size());
                scene.meshes.push_back(scene.meshes[instance.mesh]);
            }
            isTaken[instance.mesh] = true;
            toDeform.emplace_back(std::move(shape), found->second);
        }
        meshOf.back() = found->second;
    }
    for (const auto& [shape, mesh] : toDeform) {
        const auto& [source, skin, weights] = shape;
        const auto joints = skin == kNone ? std::span<const glm::mat4x3>{} : applier.JointMatricesOf(skin);
        for (Primitive& primitive : scene.meshes[mesh].primitives) Deform(primitive, weights, joints);
    }
    for (Instance& instance : scene.instances)
        if (instance.isDeformed && HasSkin(scene, instance))
            AttachToNode(instance, applier.NodeTransforms()[instance.node]);
    for (size_t i = 0; i < meshOf.size(); ++i) {
        scene.instances[i].mesh = meshOf[i];
        scene.instances[i].isDeformed = false;
    }
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

}  // namespace raygraph::scene
