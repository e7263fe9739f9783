#include "editor/app/document.h"

#include <algorithm>
#include <utility>

#include "base/overloaded.h"
#include "base/path_text.h"
#include "base/text.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/gltf/save_gltf.h"
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
      m_isNodeAnimated(AnimatedNodes(m_scene)) {
    if (!m_scene.animations.empty()) {
        m_rest = m_scene;
        m_rest.animations.clear();
    }
    if (!hash.empty()) m_hashes[m_scene.variant] = std::move(hash);
    m_children.resize(m_scene.nodes.size());
    for (const uint32_t node : m_scene.nodeOrder) {
        const uint32_t parent = m_scene.nodes[node].parent;
        (parent == scene::kNone ? m_roots : m_children[parent]).push_back(node);
    }
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

void Document::Apply(const Edit& edit, GpuScene& gpu) {
    const Edit wanted = ToRestEdit(edit);
    const Edit before = Current(wanted);
    if (const TransformEdit* const moved = std::get_if<TransformEdit>(&edit)) RequireValidPlacement(*moved);
    Put(wanted, gpu);
    try {
        RequireShown(edit);
    } catch (const Error&) {
        Put(before, gpu);
        throw;
    }
    if (m_saved > m_done) m_saved = kNeverSaved;  // the saved state cannot be reached any more
    m_steps.resize(m_done);
    if (m_isOpen && m_done > 0 && IsSameTarget(m_steps.back().after, wanted)) {
        m_steps.back().after = wanted;
    } else {
        m_steps.push_back({before, wanted});
        ++m_done;
    }
    m_isOpen = true;
}

void Document::Save(const std::filesystem::path& to) {
    if (m_file.empty()) throw Error(ErrorKind::Usage, "no scene is open");
    if (m_stamp && StampOf(m_file) != m_stamp)
        throw MakeError(ErrorKind::BadInput, "{}: has changed since it was opened; not saved", m_file);
    scene::SaveGltf(m_file, Rest(), to, {.root = m_root});
    if (IsEdited()) m_hashes.clear();
    m_isOpen = false;
    m_file = to;
    m_stamp = StampOf(to);
    m_saved = m_done;
}

std::filesystem::path Document::SaveRecoveryCopy() const {
    const std::string name = m_file.stem().string() + "-recovered", extension = m_file.extension().string();
    const auto isThere = [](const std::filesystem::path& file) {
        std::error_code unknown;
        return std::filesystem::exists(std::filesystem::symlink_status(file, unknown));
    };
    std::filesystem::path to = m_file;
    to.replace_filename(name + extension);
    for (int number = 2; isThere(to); ++number) to.replace_filename(Text("{}-{}{}", name, number, extension));
    scene::SaveGltf(m_file, Rest(), to, {.root = m_root});
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

void Document::Know(const FileContent& content) {
    if (!content.hash.empty() && content.file == m_file && content.stamp == m_stamp)
        m_hashes[content.variant] = content.hash;
}

void Document::ShowVariant(uint32_t variant, GpuScene& gpu) {
    gpu.SetVariant(variant);  // may throw
    scene::SetVariant(m_scene, variant);
}

void Document::Undo(GpuScene& gpu) {
    if (!CanUndo()) return;
    m_isOpen = false;
    Put(m_steps[m_done - 1].before, gpu);
    --m_done;
}

void Document::Redo(GpuScene& gpu) {
    if (!CanRedo()) return;
    m_isOpen = false;
    Put(m_steps[m_done].after, gpu);
    ++m_done;
}

}  // namespace raygraph::editor
