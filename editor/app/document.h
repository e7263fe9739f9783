// The open scene in the editor: names, hierarchy and all that can be edited, beside the GpuScene that shows
// it. Every edit goes through Apply, and can be undone.
//
// Animations pose what is shown (ShowPose); what edits change, the history holds and files get are the rest
// values below the pose. Where the two differ, an animation moves that value, and it cannot be edited until
// the rest pose is shown again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "editor/app/file_content.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/pose_applier.h"
#include "renderer/scene/scene_data.h"
#include "renderer/scene/transform_parts.h"

namespace raygraph::editor {

// The new value of a node, material or light, as it is to be shown. Indices are those of SceneData.
struct VisibilityEdit {
    uint32_t node = 0;
    bool isVisible = true;
};
struct TransformEdit {
    uint32_t node = 0;
    glm::mat4x3 local{1.0f};
    glm::vec3 rest{0.0f};  // of local's translation, see scene_data.h
};
struct MaterialEdit {
    uint32_t material = 0;
    scene::Material values;
};
struct LightEdit {
    uint32_t light = 0;
    scene::Light values;
};
// What the history holds instead of a transform where an animation moves parts of it.
struct PartsEdit {
    uint32_t node = 0;
    scene::TransformParts parts;
    glm::vec3 rest{0.0f};  // of their translation
};
using Edit = std::variant<TransformEdit, PartsEdit, VisibilityEdit, MaterialEdit, LightEdit>;

class Document {
  public:
    Document() = default;  // an empty scene without a file
    // All of `data` except vertices, texels and other data that only the device needs, in its rest pose, and
    // deformed (scene::DeformInstances). `stamp` is that of the file when it was read, `hash` that of what
    // was in it (session::HashOf), `root` the one that it was read with (scene::LoadOptions).
    Document(std::filesystem::path file, const scene::SceneData& data,
             const std::optional<FileStamp>& stamp = {}, std::string hash = {},
             std::filesystem::path root = {});

    const std::filesystem::path& File() const { return m_file; }
    // As it is shown, in its pose. Without vertex streams, images and the environment's map; with bounds and
    // names.
    const scene::SceneData& Scene() const { return m_scene; }
    // The same at rest, as far as nodes, materials and lights go.
    const scene::SceneData& Rest() const { return m_scene.animations.empty() ? m_scene : m_rest; }
    // Shows the pose of these clips, here and on the device; without any the rest pose. False: it is shown
    // already, and nothing is done. No edit, and no step of the history.
    bool ShowPose(std::span<const scene::ClipState> clips, GpuScene& gpu);
    std::span<const scene::ClipState> Clips() const { return m_clips; }
    const scene::SceneStatistics& Statistics() const { return m_statistics; }
    const std::vector<std::vector<uint32_t>>& Children() const { return m_children; }  // by node
    const std::vector<uint32_t>& Roots() const { return m_roots; }
    glm::mat4x3 LocalTransform(uint32_t node) const { return m_scene.nodes.at(node).LocalTransform(); }
    // Node to world; that of the parent, the identity for a root.
    const glm::mat4x3& WorldTransform(uint32_t node) const { return m_applier.NodeTransforms()[node].matrix; }
    glm::mat4x3 ParentTransform(uint32_t node) const;
    // Whether the node and all above it are visible.
    bool IsVisible(uint32_t node) const { return m_applier.IsNodeVisible(node); }
    // Joints alone place what the node shows: its own transform is of no account.
    bool IsPlacedByJoints(uint32_t node) const;
    // Of a node and all below it, world space.
    scene::Bounds BoundsOf(uint32_t node) const;
    // The instances of the node and of its descendants.
    std::vector<uint32_t> InstancesUnder(uint32_t node) const;

    // Makes the edit, here and on the device. Edits of one thing that follow each other before Settle are one
    // step of the history, as while a slider is dragged. Error{Usage} for a value that cannot be, or that an
    // animation has in its place; nothing changes then.
    void Apply(const Edit& edit, GpuScene& gpu);
    // Ends a step: the next edit starts a new one.
    void Settle() { m_isOpen = false; }
    bool CanUndo() const { return m_done > 0; }
    bool CanRedo() const { return m_done < m_steps.size(); }
    // Shows the variant, here and on the device; scene::kNone: none. No edit, and no step of the history.
    void ShowVariant(uint32_t variant, GpuScene& gpu);
    void Undo(GpuScene& gpu);
    void Redo(GpuScene& gpu);
    // The number of edits that are applied, not undone.
    size_t EditCount() const { return m_done; }
    // Grows with every edit, undo and redo, so that equal counts are equal states.
    uint64_t ChangeCount() const { return m_changes; }
    // Whether they differ from the saved ones.
    bool IsEdited() const { return m_done != m_saved; }
    // Writes the file with its edits to another, or over it (scene::SaveGltf), which then is the document's.
    // Error{BadInput} if the file has changed since it was loaded, and as SaveGltf.
    void Save(const std::filesystem::path& to);
    // Writes it with its edits to a new file beside its own, NAME-recovered.gltf or .glb, and returns that.
    // The document stays as it is. Errors as SaveGltf.
    std::filesystem::path SaveBeside() const;
    // What is in the file, if it is what is open. Its hash is not known when edits were saved since it was
    // read; Know keeps it, unless the file is another by now.
    FileContent Content() const;
    void Know(const FileContent& content);

  private:
    struct Step {
        Edit before, after;  // of rest values
    };
    // What a node places: instances, which are neighbors; light and camera: scene::kNone for none.
    struct Placed {
        uint32_t firstInstance = 0, instanceCount = 0, light = scene::kNone, camera = scene::kNone;

        uint32_t InstanceEnd() const { return firstInstance + instanceCount; }
    };
    // Whether a clip that is shown has a channel for it.
    bool IsDriven(scene::AnimatedProperty property, uint32_t object) const;
    // The edit of rest values that gives what is shown these.
    Edit OfRest(const Edit& shown) const;
    Edit OfRest(const TransformEdit& shown) const;
    Edit Current(const Edit& of) const;
    // That no animation has another value in the place of one that was edited.
    void RequireShown(const Edit& edit) const;
    // A node keeps its area where it or a node below places a mesh, and its inverse where one places a light.
    void RequirePlace(const TransformEdit& edit) const;
    // An edit of rest values: here, and what follows from it on the device. On an error nothing has changed.
    void Put(const Edit& edit, GpuScene& gpu);
    void Set(const Edit& edit);                    // its parts: the values here,
    void Follow(const Edit& edit, GpuScene& gpu);  // and what follows from them in the pose that is shown
    // To the device; everything if an error has kept it from taking all.
    void Push(const scene::PoseChanges& changes, GpuScene& gpu);
    // The node, and all below it, parents first.
    std::vector<uint32_t> Subtree(uint32_t node) const;

    std::filesystem::path m_file, m_root;
    std::optional<FileStamp> m_stamp;
    std::map<uint32_t, std::string> m_hashes;  // of what is in the file, by variant, as far as they are known
    scene::SceneData m_scene, m_rest;          // the latter empty of a scene without animations
    scene::PoseEvaluator m_evaluator{m_scene};
    scene::PoseApplier m_applier{m_scene};
    std::vector<scene::ClipState> m_clips;
    bool m_isDeviceBehind = false;  // it has not taken all that was changed here
    scene::SceneStatistics m_statistics;
    std::vector<std::vector<uint32_t>> m_children;
    std::vector<uint32_t> m_roots;
    std::vector<Placed> m_placed;        // by node
    std::vector<bool> m_isNodeAnimated;  // some animation changes a part of its transform
    std::vector<Step> m_steps;
    size_t m_saved = 0;  // m_done when it was saved; kNeverSaved: no state equals the saved one
    size_t m_done = 0;   // steps that are in effect; those after it can be redone
    uint64_t m_changes = 0;
    bool m_isOpen = false;  // the last step may be extended
};

}  // namespace raygraph::editor
