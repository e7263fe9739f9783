#include "editor/app/document.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <utility>

#include "base/files.h"
#include "base/overloaded.h"
#include "base/text.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"
#include "renderer/scene/model/variants.h"

namespace raygraph::editor {

namespace {

constexpr size_t kNeverSaved = ~size_t{0};

scene::SceneData OutlineOf(const scene::SceneData& data) {
    scene::SceneData outline = scene::PoseOutline(data);
    outline.textures = data.textures;
    outline.profiles = data.profiles;
    outline.environment = {data.environment.name, data.environment.faceSize, {}};
    outline.warnings = data.warnings;
    return outline;
}

// Returns per node whether animations change a part of its transform; nodes with a matrix do not count.
std::vector<bool> AnimatedNodes(const scene::SceneData& scene) {
    using Property = scene::AnimatedProperty;
    std::vector<bool> isAnimated(scene.nodes.size());
    for (const scene::Animation& animation : scene.animations)
        for (const auto& [sampler, target] : animation.channels)
            if (target.property == Property::Translation || target.property == Property::Rotation ||
                target.property == Property::Scale)
                isAnimated[target.object] = !scene.nodes[target.object].matrix;
    return isAnimated;
}

// Returns per node whether it is a joint of a skin.
std::vector<bool> JointsOf(const scene::SceneData& scene) {
    std::vector<bool> isJoint(scene.nodes.size());
    for (const scene::Skin& skin : scene.skins)
        for (const uint32_t joint : skin.joints) isJoint[joint] = true;
    return isJoint;
}

// Returns whether two edits have the same target.
bool IsSameTarget(const Edit& a, const Edit& b) {
    if (a.index() != b.index()) return false;
    return std::visit(
        Overloaded{
            [&](const TransformEdit& e) { return e.node == std::get<TransformEdit>(b).node; },
            [&](const PartsEdit& e) { return e.node == std::get<PartsEdit>(b).node; },
            [&](const VisibilityEdit& e) { return e.node == std::get<VisibilityEdit>(b).node; },
            [&](const MaterialEdit& e) { return e.material == std::get<MaterialEdit>(b).material; },
            [&](const LightEdit& e) { return e.light == std::get<LightEdit>(b).light; },
            [](const auto&) { return false; },  // each edit of the hierarchy is a step of its own
        },
        a);
}

}  // namespace

Document::Document(std::filesystem::path file, const scene::SceneData& data,
                   const std::optional<FileStamp>& stamp, std::string hash, std::filesystem::path root)
    : m_file(std::move(file)),
      m_root(std::move(root)),
      m_stamp(stamp),
      m_scene(OutlineOf(data)),
      m_evaluator(m_scene),
      m_applier(m_scene),
      m_statistics(scene::Statistics(data)),
      m_isJoint(JointsOf(m_scene)),
      m_isNodeAnimated(AnimatedNodes(m_scene)) {
    if (!m_scene.animations.empty()) {
        m_rest = m_scene;
        m_rest.animations.clear();
    }
    if (!hash.empty()) m_hashes[m_scene.variant] = std::move(hash);
    TakeImages(data);
    std::ranges::transform(data.meshes, std::back_inserter(m_meshFacts), FactsOf);
    m_allChildren.resize(m_scene.nodes.size());
    m_isRemoved.resize(m_scene.nodes.size());
    for (const uint32_t node : m_scene.nodeOrder) SiblingsOf(m_scene.nodes[node].parent).push_back(node);
    UpdateOrder();
    m_placed.resize(m_scene.nodes.size());
    const auto place = [&](const auto& things, uint32_t Placed::*index) {
        for (uint32_t i = 0; i < things.size(); ++i)
            if (things[i].node != scene::kNone) m_placed[things[i].node].*index = i;
    };
    for (uint32_t i = 0; i < m_scene.instances.size(); ++i) {
        if (m_scene.instances[i].node == scene::kNone) continue;
        Placed& placed = m_placed[m_scene.instances[i].node];
        if (placed.instanceCount++ == 0) placed.firstInstance = i;
    }
    place(m_scene.lights, &Placed::light);
    place(m_scene.cameras, &Placed::camera);
}

NodeKind Document::KindOf(uint32_t node) const {
    const Placed& placed = m_placed.at(node);
    if (m_scene.nodes[node].mesh != scene::kNone) return NodeKind::Mesh;
    if (placed.light != scene::kNone) return NodeKind::Light;
    if (placed.camera != scene::kNone) return NodeKind::Camera;
    return node < m_isJoint.size() && m_isJoint[node] ? NodeKind::Joint : NodeKind::Empty;
}

std::vector<uint32_t> Document::Subtree(uint32_t node) const {
    std::vector<uint32_t> nodes{node};
    for (size_t i = 0; i < nodes.size(); ++i)
        for (const uint32_t child : m_children[nodes[i]]) nodes.push_back(child);
    return nodes;
}

std::vector<uint32_t> Document::InstancesUnder(uint32_t node) const {
    std::vector<uint32_t> instances;
    for (const uint32_t below : Subtree(node))
        for (uint32_t i = m_placed[below].firstInstance; i < m_placed[below].InstanceEnd(); ++i)
            instances.push_back(i);
    return instances;
}

glm::mat4x3 Document::ParentTransform(uint32_t node) const {
    const uint32_t parent = m_scene.nodes.at(node).parent;
    return parent == scene::kNone ? glm::mat4x3(1.0f) : WorldTransform(parent);
}

scene::Bounds Document::BoundsOf(uint32_t node) const {
    scene::Bounds bounds;
    for (const uint32_t instance : InstancesUnder(node)) bounds.Extend(m_applier.BoundsOf(instance));
    return bounds;
}

bool Document::IsPlacedBySkin(uint32_t node) const {
    const Placed& placed = m_placed.at(node);
    return placed.instanceCount > 0 && scene::HasSkin(m_scene, m_scene.instances[placed.firstInstance]) &&
           m_children[node].empty() && placed.light == scene::kNone && placed.camera == scene::kNone;
}

bool Document::ShowPose(std::span<const scene::ClipState> clips, GpuScene& gpu) {
    if (!m_isDeviceStale && std::ranges::equal(clips, m_clips)) return false;
    const scene::Pose& pose = m_evaluator.Evaluate(m_scene, clips);  // may throw
    m_clips.assign(clips.begin(), clips.end());
    Push(m_applier.Apply(m_scene, pose), gpu);
    return true;
}

void Document::Apply(std::span<const Edit> edits, GpuScene& gpu) {
    std::vector<Edit> wanted;
    for (const Edit& edit : edits) wanted.push_back(ToRestEdit(edit));
    const bool isReparented =
        std::ranges::any_of(edits, [](const Edit& edit) { return std::holds_alternative<ParentEdit>(edit); });
    for (const Edit& edit : edits)
        if (const TransformEdit* const moved = std::get_if<TransformEdit>(&edit); moved && !isReparented)
            RequireValidPlacement(*moved);
    std::vector<Edit> before = Put(wanted, gpu);
    try {
        for (const Edit& edit : edits) RequireShown(edit);
    } catch (const Error&) {
        Put(before, gpu);
        throw;
    }
    if (m_saved > m_done) m_saved = kNeverSaved;  // the saved state cannot be reached any more
    m_steps.resize(m_done);
    if (m_isOpen && m_done > 0 && std::ranges::equal(m_steps.back().after, wanted, IsSameTarget)) {
        m_steps.back().after = std::move(wanted);
    } else {
        m_steps.push_back({std::move(before), std::move(wanted)});
        ++m_done;
    }
    m_isOpen = true;
}

void Document::WriteFile(const std::filesystem::path& to, bool isSelfContained) const {
    const std::vector<scene::ReplacedImage> images = ReplacedImages();
    scene::SaveGltf(m_file, Rest(), to, {.root = m_root},
                    {.json = m_json,
                     .copiedFrom = m_copiedFrom,
                     .images = images,
                     .file = m_content,
                     .isSelfContained = isSelfContained});
}

void Document::Save(const std::filesystem::path& to) {
    if (m_file.empty()) throw Error(ErrorKind::Usage, "no scene is open");
    if (m_stamp && StampOf(m_file) != m_stamp)
        throw MakeError(ErrorKind::BadInput, "{}: has changed since it was opened; not saved", m_file);
    if (m_json.empty()) m_json = scene::ReadGltfJson(m_file);
    // The file loses the old image, which undo puts back; in memory the file is smaller than its images
    if (m_content.empty() && !ReplacedImages().empty())
        m_content = ReadFile(m_file, scene::LoadLimits().maxFileBytes);
    WriteFile(to);
    if (IsEdited()) m_hashes.clear();
    m_isOpen = false;
    m_file = to;
    m_stamp = StampOf(to);
    m_saved = m_done;
}

std::filesystem::path Document::SaveRecoveryCopy() const {
    const std::string name = m_file.stem().string() + "-recovered", extension = m_file.extension().string();
    const auto exists = [](const std::filesystem::path& file) {
        std::error_code unknown;
        return std::filesystem::exists(std::filesystem::symlink_status(file, unknown));
    };
    std::filesystem::path to = m_file;
    to.replace_filename(name + extension);
    for (int number = 2; exists(to); ++number) to.replace_filename(Text("{}-{}{}", name, number, extension));
    WriteFile(to);
    return to;
}

FileContent Document::Content() const {
    if (m_file.empty() || IsEdited()) return {};
    const auto known = m_hashes.find(m_scene.variant);
    return {.file = m_file,
            .root = m_root,
            .stamp = m_stamp,
            .variant = m_scene.variant,
            .hash = known == m_hashes.end() ? "" : known->second};
}

void Document::RecordContent(const FileContent& content) {
    if (!content.hash.empty() && content.file == m_file && content.stamp == m_stamp)
        m_hashes[content.variant] = content.hash;
}

void Document::ShowVariant(uint32_t variant, GpuScene& gpu) {
    gpu.SetVariant(variant);  // may throw
    scene::SetVariant(m_scene, variant);
}

void Document::PutStep(const std::vector<Edit>& edits, GpuScene& gpu) {
    m_isOpen = false;
    Put(edits, gpu);
    m_restored.clear();
    for (const Edit& edit : edits)
        if (const auto* const presence = std::get_if<PresenceEdit>(&edit); presence && presence->isPresent)
            m_restored.push_back(presence->node);
}

void Document::Undo(GpuScene& gpu) {
    if (!CanUndo()) return;
    PutStep(m_steps[m_done - 1].before, gpu);
    --m_done;
}

void Document::Redo(GpuScene& gpu) {
    if (!CanRedo()) return;
    PutStep(m_steps[m_done].after, gpu);
    ++m_done;
}

// --- Edits: their effect on the rest values, and their consequences ---

namespace {

constexpr float kLargest = 1e18f;  // bound of a transform's numbers, so that their products stay finite

void RequireIndex(const char* what, uint32_t index, size_t count) {
    if (index >= count) throw MakeError(ErrorKind::Usage, "there is no {} {}", what, index);
}

// Copies to `rest` the parts in which `wanted` differs from `shown`.
void CopyChanges(const scene::TextureRef& shown, const scene::TextureRef& wanted, scene::TextureRef& rest) {
    if (wanted.texture != shown.texture) rest.texture = wanted.texture;
    if (wanted.texCoord != shown.texCoord) rest.texCoord = wanted.texCoord;
    scene::ForEachTransformField([&](const auto& field) {
        if (wanted.transform.*field.member != shown.transform.*field.member)
            rest.transform.*field.member = wanted.transform.*field.member;
    });
}
template <typename T>
void CopyChanges(const T& shown, const T& wanted, T& rest) {
    if (wanted != shown) rest = wanted;
}

[[noreturn]] void RejectAnimated() {
    throw Error(ErrorKind::Usage, "an animation changes this: it can be edited in the rest pose");
}

}  // namespace

bool Document::IsAnimated(scene::AnimatedProperty property, uint32_t object) const {
    const auto isMatch = [&](const scene::AnimationChannel& channel) {
        return channel.target.property == property && channel.target.object == object;
    };
    return std::ranges::any_of(m_clips, [&](const scene::ClipState& clip) {
        return clip.weight > 0.0f &&
               std::ranges::any_of(m_scene.animations[clip.animation].channels, isMatch);
    });
}

Edit Document::ToRestEdit(const TransformEdit& shown) const {
    RequireIndex("node", shown.node, m_scene.nodes.size());
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row)
            if (!(std::abs(shown.local[column][row]) < kLargest))
                throw Error(ErrorKind::Usage, "a node's transform has to be made of finite numbers");
    const scene::Node& node = m_scene.nodes[shown.node];
    const bool isTurned = shown.rest == glm::vec3(0.0f) && shown.local[3] == node.LocalTransform()[3];
    const glm::vec3 rest =
        isTurned ? node.translationResidual : shown.rest;  // keep the residual when only the rotation changed
    if (!m_isNodeAnimated[shown.node]) return TransformEdit{shown.node, shown.local, rest};
    const std::optional<scene::TransformParts> wanted = scene::PartsOf(shown.local, node);
    if (!wanted) throw Error(ErrorKind::Usage, "what an animation moves can neither be flat nor sheared");
    const scene::Node& own = m_rest.nodes[shown.node];
    PartsEdit edit{shown.node, {own.translation, own.rotation, own.scale}, own.translationResidual};
    const auto take = [&](scene::AnimatedProperty property, const auto& before, const auto& after, auto& to) {
        if (after == before) return;
        if (IsAnimated(property, shown.node)) RejectAnimated();
        to = after;
    };
    using Property = scene::AnimatedProperty;
    take(Property::Translation, node.translation, wanted->translation, edit.parts.translation);
    take(Property::Translation, node.translationResidual, rest, edit.rest);
    take(Property::Rotation, node.rotation, wanted->rotation, edit.parts.rotation);
    take(Property::Scale, node.scale, wanted->scale, edit.parts.scale);
    return edit;
}

Edit Document::ToRestEdit(const Edit& shown) const {
    return std::visit(Overloaded{[&](const TransformEdit& e) { return ToRestEdit(e); },
                                 [&](const PartsEdit& e) -> Edit { return e; },
                                 [&](const VisibilityEdit& e) -> Edit {
                                     RequireIndex("node", e.node, m_scene.nodes.size());
                                     return e;
                                 },
                                 [&](const MaterialEdit& e) -> Edit {
                                     RequireIndex("material", e.material, m_scene.materials.size());
                                     MaterialEdit edit{e.material, Rest().materials[e.material]};
                                     scene::ForEachMaterialField([&](const auto& field) {
                                         CopyChanges(m_scene.materials[e.material].*field.member,
                                                     e.values.*field.member, edit.values.*field.member);
                                     });
                                     scene::Check(edit.values, Text("material {}", e.material));
                                     return edit;
                                 },
                                 [&](const LightEdit& e) -> Edit {
                                     RequireIndex("light", e.light, m_scene.lights.size());
                                     LightEdit edit{e.light, Rest().lights[e.light]};
                                     scene::ForEachLightField(edit.values, [&](const auto& field) {
                                         CopyChanges(m_scene.lights[e.light].*field.member,
                                                     e.values.*field.member, edit.values.*field.member);
                                     });
                                     scene::Check(edit.values, Text("light {}", e.light));
                                     return edit;
                                 },
                                 [&](const ImageEdit& e) -> Edit { return e; },
                                 [&](const auto& e) -> Edit {  // the hierarchy
                                     RequireIndex("node", e.node, m_scene.nodes.size());
                                     return e;
                                 }},
                      shown);
}

Edit Document::Current(const Edit& of) const {
    const scene::SceneData& rest = Rest();
    return std::visit(
        Overloaded{
            [&](const TransformEdit& e) -> Edit {
                const scene::Node& node = rest.nodes.at(e.node);
                return TransformEdit{e.node, node.LocalTransform(), node.translationResidual};
            },
            [&](const PartsEdit& e) -> Edit {
                const scene::Node& node = rest.nodes.at(e.node);
                return PartsEdit{
                    e.node, {node.translation, node.rotation, node.scale}, node.translationResidual};
            },
            [&](const VisibilityEdit& e) -> Edit {
                return VisibilityEdit{e.node, rest.nodes.at(e.node).isVisible};
            },
            [&](const MaterialEdit& e) -> Edit {
                return MaterialEdit{e.material, rest.materials.at(e.material)};
            },
            [&](const LightEdit& e) -> Edit {
                return LightEdit{e.light, rest.lights.at(e.light)};
            },
            [&](const NameEdit& e) -> Edit {
                return NameEdit{e.node, rest.nodes.at(e.node).name};
            },
            [&](const ParentEdit& e) -> Edit {
                const uint32_t parent = rest.nodes.at(e.node).parent;
                const std::vector<uint32_t>& siblings =
                    parent == scene::kNone ? m_allRoots : m_allChildren[parent];
                const auto next = std::ranges::find(siblings, e.node) + 1;
                return ParentEdit{e.node, parent, next == siblings.end() ? scene::kNone : *next};
            },
            [&](const PresenceEdit& e) -> Edit {
                return PresenceEdit{e.node, !m_isRemoved.at(e.node)};
            },
            [&](const ImageEdit& e) -> Edit {
                return ImageEdit{e.image, m_images.at(e.image).shown};
            },
        },
        of);
}

void Document::Set(const Edit& edit) {
    const auto setIn = [&](scene::SceneData& scene) {
        std::visit(Overloaded{
                       [&](const TransformEdit& e) {
                           scene.nodes[e.node].matrix = e.local;
                           scene.nodes[e.node].translationResidual = e.rest;
                       },
                       [&](const PartsEdit& e) {
                           scene::Node& node = scene.nodes[e.node];
                           node.translation = e.parts.translation;
                           node.translationResidual = e.rest;
                           node.rotation = e.parts.rotation;
                           node.scale = e.parts.scale;
                       },
                       [&](const VisibilityEdit& e) { scene.nodes[e.node].isVisible = e.isVisible; },
                       [&](const MaterialEdit& e) { scene.materials[e.material] = e.values; },
                       [&](const LightEdit& e) {
                           scene::ForEachLightField(e.values, [&](const auto& field) {
                               scene.lights[e.light].*field.member = e.values.*field.member;
                           });
                       },
                       [&](const NameEdit& e) { scene.nodes[e.node].name = e.name; },
                       [&](const ParentEdit& e) { scene.nodes[e.node].parent = e.parent; },
                       [](const PresenceEdit&) {},
                       [](const ImageEdit&) {},
                   },
                   edit);
    };
    if (const ImageEdit* const shown = std::get_if<ImageEdit>(&edit))
        m_images[shown->image].shown = shown->choice;
    if (const ParentEdit* const moved = std::get_if<ParentEdit>(&edit)) {
        std::erase(SiblingsOf(m_scene.nodes[moved->node].parent), moved->node);
        std::vector<uint32_t>& siblings = SiblingsOf(moved->parent);
        siblings.insert(std::ranges::find(siblings, moved->before), moved->node);
    }
    if (const PresenceEdit* const presence = std::get_if<PresenceEdit>(&edit))
        m_isRemoved[presence->node] = !presence->isPresent;
    setIn(m_scene);
    if (m_scene.animations.empty()) return;
    setIn(m_rest);
    m_evaluator.ReadRest(m_rest);
}

void Document::Follow(std::span<const Edit> edits, GpuScene& gpu) {
    ShowImages(gpu);
    std::vector<uint32_t> nodes, materials, lights;
    bool isReordered = false;
    for (const Edit& edit : edits) {
        std::visit(Overloaded{
                       [&](const MaterialEdit& e) { materials.push_back(e.material); },
                       [&](const LightEdit& e) { lights.push_back(e.light); },
                       [](const NameEdit&) {},
                       [](const ImageEdit&) {},
                       [&](const auto& e) {
                           using Kind = std::decay_t<decltype(e)>;
                           isReordered |=
                               std::is_same_v<Kind, ParentEdit> || std::is_same_v<Kind, PresenceEdit>;
                           nodes.push_back(e.node);
                       },
                   },
                   edit);
    }
    if (isReordered) {
        UpdateOrder();
        m_applier.Refresh(m_scene);
        m_isDeviceStale = true;  // no list of changes says what Refresh has changed
    }
    const scene::PoseChanges& changes =
        m_applier.Apply(m_scene, m_evaluator.Evaluate(m_scene, m_clips), nodes);
    if (materials.empty() && lights.empty()) {
        Push(changes, gpu);
        return;
    }
    scene::PoseChanges all = changes;
    all.materials.insert(all.materials.end(), materials.begin(), materials.end());
    all.lights.insert(all.lights.end(), lights.begin(), lights.end());
    Push(all, gpu);
}

void Document::Push(const scene::PoseChanges& changes, GpuScene& gpu) {
    const bool wasBehind = std::exchange(m_isDeviceStale, true);
    if (wasBehind)
        gpu.SetPose(m_scene, m_applier);
    else
        gpu.SetPose(m_scene, m_applier, changes);
    m_isDeviceStale = false;
}

std::vector<Edit> Document::Put(std::span<const Edit> edits, GpuScene& gpu) {
    ++m_changes;
    std::vector<Edit> before;
    for (const Edit& edit : edits) {
        before.push_back(Current(edit));
        Set(edit);
    }
    std::ranges::reverse(before);
    try {
        Follow(edits, gpu);
    } catch (...) {
        for (const Edit& edit : before) Set(edit);
        Follow(before, gpu);
        throw;
    }
    return before;
}

void Document::RequireShown(const Edit& edit) const {
    bool isShown = true;
    std::visit(Overloaded{
                   [](const auto&) {},
                   [&](const VisibilityEdit& e) { isShown = m_scene.nodes[e.node].isVisible == e.isVisible; },
                   [&](const MaterialEdit& e) {
                       const scene::Material& shown = m_scene.materials[e.material];
                       scene::ForEachMaterialField([&](const auto& field) {
                           isShown &= shown.*field.member == e.values.*field.member;
                       });
                   },
                   [&](const LightEdit& e) {
                       const scene::Light& shown = m_scene.lights[e.light];
                       scene::ForEachLightField(shown, [&](const auto& field) {
                           isShown &= shown.*field.member == e.values.*field.member;
                       });
                   },
               },
               edit);
    if (!isShown) RejectAnimated();
}

void Document::RequireValidPlacement(const TransformEdit& edit) const {
    const scene::PlacedTransform before{WorldTransform(edit.node)};
    const bool hadInverse = scene::CanInvert(before.matrix);
    const bool hadArea = scene::WithThickness(before, {}).has_value();
    const uint32_t parent = m_scene.nodes[edit.node].parent;
    const scene::PlacedTransform local{edit.local, edit.rest};
    const scene::PlacedTransform placed =
        parent == scene::kNone ? local : scene::Compose(m_applier.NodeTransforms()[parent], local);
    const std::string subject = Text("node {}", edit.node);
    for (const uint32_t below : Subtree(edit.node)) {
        if (hadArea && m_placed[below].instanceCount > 0) scene::CheckedPlacement(placed, {}, subject);
        if (hadInverse && m_placed[below].light != scene::kNone) scene::CheckTransform(placed, subject);
    }
}

}  // namespace raygraph::editor
