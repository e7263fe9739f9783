#include "renderer/scene/model/check.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <type_traits>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/animation/animated_values.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/model/check_subject.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::scene {
namespace {

template <typename Owner>
void CheckField(float value, const Field<Owner, float>& field, const Subject& subject) {
    if (!(value == 0.0f && field.range.mayBeZero))
        subject.RequireRange(field.name, value, field.range.min, field.range.max);
}
template <typename Owner, int Length>
void CheckField(const glm::vec<Length, float>& value, const Field<Owner, glm::vec<Length, float>>& field,
                const Subject& subject) {
    for (int i = 0; i < Length; ++i)
        subject.RequireRange(field.name, value[i], field.range.min, field.range.max);
}
void CheckField(bool, const MaterialField<bool>&, const Subject&) {}
void CheckField(AlphaMode, const MaterialField<AlphaMode>&, const Subject&) {}
void CheckField(uint32_t, const MaterialField<uint32_t>&, const Subject&) {}
// Checks the reference's numbers; CheckTextures checks the indices, which needs the whole scene.
void CheckField(const TextureRef& reference, const TextureField&, const Subject& subject) {
    ForEachTransformField(
        [&](const auto& field) { CheckField(reference.transform.*field.member, field, subject); });
}

void CheckNumbers(const Material& material, const Subject& subject) {
    const auto check = [&](const auto& field) { CheckField(material.*field.member, field, subject); };
    ForEachMaterialField(check);
    ForEachFieldOf(material, check);  // its ranges may be closer
    subject.Require(AllFinite(material.EmittedRadiance()),
                    "emissiveFactor times emissiveStrength is infinite");
}

void CheckTextures(const Material& material, size_t textureCount, const Subject& subject) {
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>) {
            const TextureRef& ref = material.*field.member;
            if (!ref.IsPresent()) return;
            subject.RequireIndex("a texture", static_cast<uint32_t>(ref.texture), textureCount);
            subject.Require(ref.texCoord == 0 || ref.texCoord == 1, "a texCoord is neither 0 nor 1");
        }
    });
}

void CheckValues(const Light& light, const Subject& subject) {
    ForEachLightField(light, [&](const auto& field) { CheckField(light.*field.member, field, subject); });
    subject.Require(light.profile == kNone || light.type == LightType::Point,
                    "it has a profile, and is no point light");
    subject.Require(AllFinite(light.color * light.intensity), "color times intensity is infinite");
    subject.Require(IsFinite(light.lightToWorld) && IsFinite(light.translationResidual),
                    "its transform is not finite");
    subject.Require(HasCone(light), kConeRule);
}

bool AreIncreasing(const std::vector<float>& angles) {
    return std::ranges::all_of(angles, [](float angle) { return std::isfinite(angle); }) &&
           std::ranges::adjacent_find(angles, std::greater_equal<>()) == angles.end();
}

void CheckProfile(const LightProfile& profile, const Subject& subject) {
    constexpr float kPi = glm::pi<float>(), kRounding = 1e-5f;
    const bool isC = profile.type == PhotometricType::C;
    const size_t vertical = profile.vertical.size(), horizontal = profile.horizontal.size();
    subject.Require(vertical >= 2 && horizontal >= (isC ? 1 : 2), "it has too few angles");
    if (profile.candela.size() != vertical * horizontal)
        subject.Fail(Text("{} intensities of {} x {} angles", profile.candela.size(), horizontal, vertical));
    subject.Require(AreIncreasing(profile.vertical) && AreIncreasing(profile.horizontal),
                    "its angles must be finite and increase");
    subject.Require(profile.vertical.front() >= (isC ? 0.0f : -kPi - kRounding) &&
                        profile.vertical.back() <= kPi + kRounding,
                    "its vertical angles are out of range");
    const float first = profile.horizontal.front(), last = profile.horizontal.back();
    if (!isC)
        subject.Require(first >= -kPi - kRounding && last <= kPi + kRounding,
                        "its horizontal angles are out of range");
    else if (horizontal > 1)
        subject.Require(std::abs(last - first - 2.0f * kPi) <= kRounding,
                        "its horizontal angles must be a turn");
    for (const float candela : profile.candela)
        subject.RequireRange("an intensity", candela, 0.0f, kUnbounded);
}

void CheckValues(const Camera& camera, const Subject& subject) {
    subject.Require(IsFinite(camera.cameraToWorld) && IsFinite(camera.translationResidual),
                    "its transform is not finite");
    ForEachCameraField(camera.projection,
                       [&](const auto& field) { CheckField(camera.*field.member, field, subject); });
}

void CheckTransformOf(const PlacedTransform& transform, const Subject& subject) {
    subject.Require(IsFinite(transform.matrix) && IsFinite(transform.rest), "its transform is not finite");
    subject.Require(CanInvert(transform.matrix),
                    "its transform is scaled to nothing or flat, it has no inverse");
}

PlacedTransform PlacementOf(const PlacedTransform& transform, const Bounds& mesh, const Subject& subject) {
    subject.Require(IsFinite(transform.matrix) && IsFinite(transform.rest), "its transform is not finite");
    const std::optional<PlacedTransform> shown = WithThickness(transform, mesh);
    subject.Require(shown.has_value(), "its transform is scaled to nothing or to a line");
    return *shown;
}

void CheckVariants(const Primitive& primitive, const SceneData& scene, const Subject& subject) {
    const std::vector<VariantMaterial>& variants = primitive.variants;
    for (size_t i = 0; i < variants.size(); ++i) {
        subject.RequireIndex("a variant", variants[i].variant, scene.variants.size(), true);
        subject.RequireIndex("the material of a variant", variants[i].material, scene.materials.size());
        subject.Require(i == 0 || variants[i - 1].variant < variants[i].variant,
                        "its variants do not ascend");
    }
    subject.Require(variants.empty() || variants.back().variant == kNone,
                    "its variants do not end with one for all others");
}

void CheckRadii(const Primitive& primitive, const Subject& subject) {
    if (primitive.indices.size() != 2 * primitive.radii.size())
        subject.Fail(Text("{} of {}, must be two each", Counted(primitive.indices.size(), "index", "indices"),
                          Counted(primitive.radii.size(), "round primitive")));
    for (size_t i = 0; i < primitive.radii.size(); ++i)
        if (!(primitive.radii[i] >= kMinRadius && primitive.radii[i] <= kMaxRadius))
            subject.Fail(Text("radii[{}] is {:.6g}, must be {:.6g} to {:.6g}", i, primitive.radii[i],
                              kMinRadius, kMaxRadius));
    subject.Require(primitive.normals.empty() && primitive.tangents.empty(),
                    "round primitives have normals or tangents");
}

void CheckPrimitive(const Primitive& primitive, size_t materialCount, const Subject& subject) {
    const size_t vertexCount = primitive.positions.size();
    subject.RequireFinite("positions", primitive.positions);
    subject.RequireStream("normals", primitive.normals, vertexCount);
    subject.RequireStream("tangents", primitive.tangents, vertexCount);
    subject.RequireStream("turns of frames", primitive.frameTurns, vertexCount);
    subject.Require(
        primitive.frameTurns.empty() || !(primitive.tangents.empty() || primitive.normals.empty()),
        "turns of frames need normals about which they turn tangents");
    subject.RequireIndex("texture coordinates of the tangents", primitive.tangentTexCoord, 2, true);
    subject.RequireStream("uv0", primitive.uv0, vertexCount);
    subject.RequireStream("uv1", primitive.uv1, vertexCount);
    subject.RequireStream("colors", primitive.colors, vertexCount);
    if (primitive.IsRound())
        CheckRadii(primitive, subject);
    else if (primitive.indices.size() % 3 != 0)
        subject.Fail(
            Text("{} no whole triangles", Counted(primitive.indices.size(), "index is", "indices are")));
    for (size_t i = 0; i < primitive.indices.size(); ++i)
        if (primitive.indices[i] >= vertexCount)
            subject.Fail(Text("indices[{}] is {}, but positions has {}", i, primitive.indices[i],
                              Counted(vertexCount, "element")));
    subject.RequireIndex("material", primitive.material, materialCount);
    const Bounds bounds = primitive.IsRound() ? RoundBounds(primitive) : BoundsOf(primitive.positions);
    if (bounds.IsEmpty()) return;
    subject.Require(AllFinite(bounds.min) && AllFinite(bounds.max), "its bounds are not finite");
    subject.Require(glm::all(glm::lessThanEqual(primitive.bounds.min, bounds.min)) &&
                        glm::all(glm::greaterThanEqual(primitive.bounds.max, bounds.max)) &&
                        AllFinite(primitive.bounds.min) && AllFinite(primitive.bounds.max),
                    "bounds are not around its positions");
}

void CheckImage(const ImageData& image, const Subject& subject) {
    const uint64_t wanted = uint64_t{4} * image.width * image.height;
    if (wanted == 0 || image.rgba.size() != wanted)
        subject.Fail(Text("{} bytes of {}x{} texels", image.rgba.size(), image.width, image.height));
    const image::BlockLevels& blocks = image.blocks;
    if (blocks.IsEmpty()) return;
    subject.Require(blocks.coding != image::BlockCoding::None, "has blocks of no coding");
    uint32_t width = image.width, height = image.height;
    for (size_t level = 0; level < blocks.levels.size(); ++level) {
        if (level > 0 && width == 1 && height == 1)
            subject.Fail(
                Text("{} of blocks, possible are {}", Counted(blocks.levels.size(), "level"), level));
        if (level > 0) width = std::max(width / 2, 1u), height = std::max(height / 2, 1u);
        if (blocks.levels[level].size() != image::BlockBytes(blocks.coding, width, height))
            subject.Fail(Text("level {}: {} bytes of blocks for {}x{} texels", level,
                              blocks.levels[level].size(), width, height));
    }
}

void CheckEnvironment(const EnvironmentLight& light, const Subject& subject) {
    const image::ImageF& map = light.map;
    const uint64_t wanted = uint64_t{4} * map.width * map.height;
    if (map.rgba.size() != wanted)
        subject.Fail(Text("environment: {} of {}x{} texels", Counted(map.rgba.size(), "number"), map.width,
                          map.height));
    for (const float value : map.rgba)
        subject.Require(std::isfinite(value) && value >= 0.0f,
                        "environment: its radiance must be finite and not negative");
}

// Requires a forest, in the order of nodeOrder.
void CheckNodes(const SceneData& scene, const Subject& subject) {
    for (size_t i = 0; i < scene.nodes.size(); ++i) {
        const Node& node = scene.nodes[i];
        const Subject here = subject.In("nodes", i);
        here.RequireIndex("parent", node.parent, scene.nodes.size(), true);
        here.RequireIndex("mesh", node.mesh, scene.meshes.size(), true);
        here.Require(IsFinite(node.LocalTransform()) && IsFinite(node.translationResidual),
                     "its transform is not finite");
    }
    std::vector<bool> isListed(scene.nodes.size(), false);
    for (size_t i = 0; i < scene.nodeOrder.size(); ++i) {
        const uint32_t node = scene.nodeOrder[i];
        const Subject here = subject.In("nodeOrder", i);
        here.RequireIndex("it", node, scene.nodes.size());
        const uint32_t parent = scene.nodes[node].parent;
        here.Require(!isListed[node], "its node is listed twice");
        here.Require(parent == kNone || isListed[parent], "its node comes before its parent");
        isListed[node] = true;
    }
}

void CheckAll(const SceneData& scene, const Subject& subject) {
    for (size_t i = 0; i < scene.images.size(); ++i) CheckImage(scene.images[i], subject.In("images", i));
    for (size_t i = 0; i < scene.textures.size(); ++i)
        subject.In("textures", i).RequireIndex("image", scene.textures[i].image, scene.images.size());
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        CheckNumbers(scene.materials[i], subject.In("materials", i));
        CheckTextures(scene.materials[i], scene.textures.size(), subject.In("materials", i));
    }
    for (size_t i = 0; i < scene.meshes.size(); ++i)
        for (size_t p = 0; p < scene.meshes[i].primitives.size(); ++p) {
            const Subject here = subject.In("meshes", i).In("primitives", p);
            CheckPrimitive(scene.meshes[i].primitives[p], scene.materials.size(), here);
            CheckVariants(scene.meshes[i].primitives[p], scene, here);
        }
    subject.RequireIndex("its variant", scene.variant, scene.variants.size(), true);
    CheckNodes(scene, subject);
    CheckDeformation(scene, subject);
    CheckAnimations(scene, subject);
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const Subject here = subject.In("instances", i);
        here.RequireIndex("mesh", scene.instances[i].mesh, scene.meshes.size());
        here.RequireIndex("node", scene.instances[i].node, scene.nodes.size(), true);
        PlacementOf({scene.instances[i].objectToWorld, scene.instances[i].translationResidual}, {}, here);
        here.Require(IsFinite(scene.instances[i].objectToNode), "its objectToNode is not finite");
    }
    for (size_t i = 0; i < scene.cameras.size(); ++i) {
        subject.In("cameras", i).RequireIndex("node", scene.cameras[i].node, scene.nodes.size(), true);
        CheckValues(scene.cameras[i], subject.In("cameras", i));
    }
    for (size_t i = 0; i < scene.lights.size(); ++i) {
        subject.In("lights", i).RequireIndex("node", scene.lights[i].node, scene.nodes.size(), true);
        CheckValues(scene.lights[i], subject.In("lights", i));
        subject.In("lights", i).RequireIndex("profile", scene.lights[i].profile, scene.profiles.size(), true);
    }
    for (size_t i = 0; i < scene.profiles.size(); ++i)
        CheckProfile(scene.profiles[i], subject.In("profiles", i));
    CheckEnvironment(scene.environment, subject);
    subject.Require(scene.bounds.IsEmpty() || (AllFinite(scene.bounds.min) && AllFinite(scene.bounds.max)),
                    "its bounds are not finite");
}

}  // namespace

bool IsFinite(const glm::vec3& vector) {
    return AllFinite(vector);
}

bool IsFinite(const glm::mat4x3& transform) {
    for (int column = 0; column < 4; ++column)
        if (!AllFinite(transform[column])) return false;
    return true;
}

bool CanInvert(const glm::mat4x3& transform) {
    const glm::mat3 linear(transform);
    const float determinant = glm::determinant(linear);
    // Elements of the inverse are at most 2 a^2 / |determinant|, with the largest element a
    constexpr float kLarge = 1e9f, kSmall = 1e-18f;
    bool isWellScaled = std::abs(determinant) >= kSmall;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row) isWellScaled &= std::abs(transform[column][row]) <= kLarge;
    if (isWellScaled) return true;
    return IsFinite(transform) && std::isnormal(determinant) && IsFinite(glm::mat4x3(glm::inverse(linear)));
}

void Check(const SceneData& scene, const std::string& subject, ErrorKind kind) {
    CheckAll(scene, {subject, kind});
}

void Check(const Material& material, const std::string& subject, ErrorKind kind) {
    CheckNumbers(material, {subject, kind});
}

void Check(const Light& light, const std::string& subject, ErrorKind kind) {
    CheckValues(light, {subject, kind});
}

void CheckTransform(const PlacedTransform& transform, const std::string& subject, ErrorKind kind) {
    CheckTransformOf(transform, {subject, kind});
}

PlacedTransform CheckedPlacement(const PlacedTransform& transform, const Bounds& mesh,
                                 const std::string& subject, ErrorKind kind) {
    return PlacementOf(transform, mesh, {subject, kind});
}

// --- What moves a scene: skins, animations, morph targets ---

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

void CheckNode(const SceneData& scene, const Node& node, bool isPlaced, const std::vector<bool>& placedSkins,
               const Subject& subject) {
    subject.RequireIndex("skin", node.skin, scene.skins.size(), true);
    subject.RequireFinite("weights", node.weights);
    const size_t weightCount = node.mesh == kNone ? 0 : scene.meshes[node.mesh].weights.size();
    if (!node.weights.empty() && node.weights.size() != weightCount)
        subject.Fail(Text("{}, its mesh has {}", Counted(node.weights.size(), "weight"), weightCount));
    subject.Require(node.skin == kNone || !isPlaced || placedSkins[node.skin],
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
    std::vector<bool> placedSkins;
    for (const Skin& skin : scene.skins)
        placedSkins.push_back(
            std::ranges::all_of(skin.joints, [&](uint32_t joint) { return bool(isPlaced[joint]); }));
    std::vector<size_t> jointCounts(scene.meshes.size());
    for (size_t i = 0; i < scene.meshes.size(); ++i)
        for (const Primitive& primitive : scene.meshes[i].primitives)
            jointCounts[i] = std::max(jointCounts[i], primitive.influences.JointCount());
    for (size_t i = 0; i < scene.nodes.size(); ++i) {
        const Node& node = scene.nodes[i];
        CheckNode(scene, node, isPlaced[i], placedSkins, subject.In("nodes", i));
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
