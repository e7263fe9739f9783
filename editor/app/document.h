// The open scene in the editor: names, hierarchy and all that can be edited, beside the GpuScene that shows
// it. Every edit goes through Apply, and can be undone.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/log.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/scene/round_primitives.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::editor {

// The new value of a node, material or light. Indices are those of SceneData.
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
using Edit = std::variant<TransformEdit, VisibilityEdit, MaterialEdit, LightEdit>;

// Detects that a file has been written since it was read.
struct FileStamp {
    std::filesystem::file_time_type time;
    uintmax_t bytes = 0;
    bool operator==(const FileStamp&) const = default;
};
std::optional<FileStamp> StampOf(const std::filesystem::path& file);  // nothing: it cannot be asked

// A scene by its file: what a picture that was saved of it is resumed with.
struct FileContent {
    std::filesystem::path file;  // "": there is none, or the scene differs from what is in it
    std::optional<FileStamp> stamp;
    uint32_t variant = scene::kNone;            // in which it is shown
    std::string hash;                           // of what is in it, so shown (session::HashOf); "": not known
    scene::PointsAndLines pointsAndLines = {};  // radii of what is in it
};
// With the hash, for which the file is read if it is not known; "": the file has been written since, or
// cannot be read. Threads: any.
FileContent WithHash(FileContent content, const Log& log = {});

class Document {
  public:
    Document() = default;  // an empty scene without a file
    // All of `data` except vertices, texels and other data that only the device needs. `stamp` is that of the
    // file when it was read, `hash` that of `data` (session::HashOf).
    Document(std::filesystem::path file, const scene::SceneData& data,
             const std::optional<FileStamp>& stamp = {}, std::string hash = {});

    const std::filesystem::path& File() const { return m_file; }
    // Without vertex streams, images and the environment's map; with bounds and names.
    const scene::SceneData& Scene() const { return m_scene; }
    const scene::SceneStatistics& Statistics() const { return m_statistics; }
    const std::vector<std::vector<uint32_t>>& Children() const { return m_children; }  // by node
    const std::vector<uint32_t>& Roots() const { return m_roots; }
    glm::mat4x3 LocalTransform(uint32_t node) const { return m_scene.nodes.at(node).LocalTransform(); }
    // Node to world; that of the parent, the identity for a root.
    const glm::mat4x3& WorldTransform(uint32_t node) const { return m_worldTransforms.at(node).matrix; }
    glm::mat4x3 ParentTransform(uint32_t node) const;
    // Whether the node and all above it are visible.
    bool IsVisible(uint32_t node) const { return m_isVisible.at(node); }
    // Of a node and all below it, world space.
    scene::Bounds BoundsOf(uint32_t node) const;
    // The instances of the node and of its descendants.
    std::vector<uint32_t> InstancesUnder(uint32_t node) const;

    // Makes the edit, here and on the device. Edits of one thing that follow each other before Settle are one
    // step of the history, as while a slider is dragged.
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
        Edit before, after;
    };
    Edit Current(const Edit& of) const;
    void Put(const Edit& edit, GpuScene& gpu);
    void PutTransform(const TransformEdit& edit, GpuScene& gpu);
    void PutVisibility(const VisibilityEdit& edit, GpuScene& gpu);
    void UpdateBounds();

    std::filesystem::path m_file;
    std::optional<FileStamp> m_stamp;
    std::map<uint32_t, std::string> m_hashes;  // of what is in the file, by variant, as far as they are known
    scene::SceneData m_scene;
    scene::SceneStatistics m_statistics;
    // What a node places: instances, which are neighbors; light and camera: scene::kNone for none.
    struct Placed {
        uint32_t firstInstance = 0, instanceCount = 0, light = scene::kNone, camera = scene::kNone;

        uint32_t InstanceEnd() const { return firstInstance + instanceCount; }
    };
    // The node, and all below it, parents first.
    std::vector<uint32_t> Subtree(uint32_t node) const;
    scene::Bounds InstanceBounds(uint32_t instance) const;

    std::vector<std::vector<uint32_t>> m_children;
    std::vector<uint32_t> m_roots;
    std::vector<Placed> m_placed;  // by node
    scene::PlacedTransform ParentPlace(uint32_t node) const;
    std::vector<scene::PlacedTransform> m_worldTransforms;  // by node
    std::vector<bool> m_isVisible;                          // by node; those above it considered
    std::vector<scene::Bounds> m_meshBounds;                // by mesh
    std::vector<scene::Bounds> m_instanceBounds;            // by instance
    std::vector<Step> m_steps;
    size_t m_saved = 0;  // m_done when it was saved; kNeverSaved: no state equals the saved one
    size_t m_done = 0;   // steps that are in effect; those after it can be redone
    uint64_t m_changes = 0;
    bool m_isOpen = false;  // the last step may be extended
};

}  // namespace raygraph::editor
