// Document holds the scene that is open in the editor: names, hierarchy and all that can be edited, beside
// the GpuScene that shows it. Every edit goes through Apply, and can be undone.
//
// Animations pose what is shown (ShowPose); what edits change, the history holds and files get are the rest
// values below the pose. Where the two differ, an animation moves that value, and it cannot be edited until
// the rest pose is shown again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "editor/app/file_content.h"
#include "editor/app/mesh_facts.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::editor {

// An edit holds the new value of a node, material or light as it is to be shown. Indices are those of
// SceneData, and stay valid: a node that is removed keeps its index, without a place in the hierarchy.
struct VisibilityEdit {
    uint32_t node = 0;
    bool isVisible = true;
};
struct TransformEdit {
    uint32_t node = 0;
    glm::mat4x3 local{1.0f};
    glm::vec3 rest{0.0f};  // residual of local's translation, in meters; see scene_data.h
};
struct MaterialEdit {
    uint32_t material = 0;
    scene::Material values;
};
struct LightEdit {
    uint32_t light = 0;
    scene::Light values;
};
// The history holds this in place of a TransformEdit for a node of which an animation moves parts.
struct PartsEdit {
    uint32_t node = 0;
    scene::TransformParts parts;
    glm::vec3 rest{0.0f};  // residual of parts.translation, in meters
};
struct NameEdit {
    uint32_t node = 0;
    std::string name;
};
struct ParentEdit {
    uint32_t node = 0;
    uint32_t parent = scene::kNone;  // kNone: the node is a root
    uint32_t before = scene::kNone;  // the sibling that follows; kNone: it becomes the last one
};
// Puts a node, with all below it, into the hierarchy, or takes it out.
struct PresenceEdit {
    uint32_t node = 0;
    bool isPresent = true;
};
// Shows one of an image's pictures: 0 is that of the scene, others are those of Document::ReplaceImage.
struct ImageEdit {
    uint32_t image = 0;
    uint32_t choice = 0;
};
using Edit = std::variant<TransformEdit, PartsEdit, VisibilityEdit, MaterialEdit, LightEdit, NameEdit,
                          ParentEdit, PresenceEdit, ImageEdit>;

// Describes the picture that an image has now.
struct ImageFacts {
    std::string name;
    std::string file;                // its path, from the scene's folder if it was not replaced; "": embedded
    uint32_t width = 0, height = 0;  // pixels
    bool isReplaced = false;         // by Document::ReplaceImage
};

// Says what a node is in the hierarchy: by the first of these that it has.
enum class NodeKind : uint8_t { Mesh, Light, Camera, Joint, Empty };

class Document {
  public:
    Document() = default;  // an empty scene without a file
    // Copies `data` in its rest pose, deformed (scene::DeformInstances), without vertices, texels and other
    // data that only the device needs. `stamp` is the file's when it was read, `hash` is that of its content
    // (session::HashOf), `root` is the one that it was read with (scene::LoadOptions).
    Document(std::filesystem::path file, const scene::SceneData& data,
             const std::optional<FileStamp>& stamp = {}, std::string hash = {},
             std::filesystem::path root = {});

    const std::filesystem::path& File() const { return m_file; }
    // Returns the scene in the pose that is shown. It has bounds and names, but no vertex streams, no images
    // and no map of the environment.
    const scene::SceneData& Scene() const { return m_scene; }
    // Returns the scene at rest. Only its nodes, materials and lights are valid.
    const scene::SceneData& Rest() const { return m_scene.animations.empty() ? m_scene : m_rest; }
    // Shows the pose of these clips, here and on the device; without clips it shows the rest pose. Returns
    // false, and does nothing, if that pose is shown already. This is no edit, and no step of the history.
    bool ShowPose(std::span<const scene::ClipState> clips, GpuScene& gpu);
    std::span<const scene::ClipState> Clips() const { return m_clips; }
    const scene::SceneStatistics& Statistics() const { return m_statistics; }
    const std::vector<std::vector<uint32_t>>& Children() const { return m_children; }  // indexed by node
    const std::vector<uint32_t>& Roots() const { return m_roots; }
    // Returns whether the node is in the hierarchy: neither removed nor in another scene of the file.
    bool IsPresent(uint32_t node) const { return node < m_isPlaced.size() && m_isPlaced[node]; }
    // Returns the node's name, else that of its mesh, else one made of its index.
    std::string NameOf(uint32_t node) const;
    NodeKind KindOf(uint32_t node) const;
    // Returns those that are below no other one of them, each once, in the order of the hierarchy.
    std::vector<uint32_t> Tops(std::span<const uint32_t> nodes) const;
    glm::mat4x3 LocalTransform(uint32_t node) const { return m_scene.nodes.at(node).LocalTransform(); }
    // Returns the node's transform to the world.
    const glm::mat4x3& WorldTransform(uint32_t node) const { return m_applier.NodeTransforms()[node].matrix; }
    glm::mat4x3 ParentTransform(uint32_t node) const;
    // Returns whether the node and all its ancestors are visible.
    bool IsVisible(uint32_t node) const { return m_applier.IsNodeVisible(node); }
    // Returns whether joints alone place the node's meshes, so that its own transform has no effect.
    bool IsPlacedBySkin(uint32_t node) const;
    // Returns the world-space bounds of a node and its descendants.
    scene::Bounds BoundsOf(uint32_t node) const;
    // Returns the instances of the node and of its descendants.
    std::vector<uint32_t> InstancesUnder(uint32_t node) const;

    // Makes the edit, here and on the device. Consecutive edits of one target before Settle are one step of
    // the history, as while a slider is dragged. Throws Error{Usage} for an invalid value, and for one that
    // an animation overrides; then nothing changes.
    void Apply(const Edit& edit, GpuScene& gpu) { Apply({&edit, 1}, gpu); }
    // Makes several edits as one step of the history: all or, on an error, none. Values that one of them
    // needs are those before all of them.
    void Apply(std::span<const Edit> edits, GpuScene& gpu);
    // --- The hierarchy. Each call is one step of the history, takes nodes with all below them, and throws
    // Error{Usage} with the reason if it cannot be done; then nothing changes.
    //
    // Adds copies beside their originals, which place the same meshes; without animations. Returns them. What
    // a skin or morph targets deform cannot be copied.
    std::vector<uint32_t> Duplicate(std::span<const uint32_t> nodes, GpuScene& gpu);
    // Adds a root with this name, or one made from it if that is taken, and the light or camera that it
    // places. Returns it.
    uint32_t Add(scene::Node node, std::optional<scene::Light> light, std::optional<scene::Camera> camera,
                 GpuScene& gpu);
    struct Removed {
        size_t nodes = 0;
        size_t channels = 0;  // of animations: they move nothing any more, and files do not get them
    };
    // A joint of a skin that something else has, also in another scene of the file, cannot be removed.
    Removed Remove(std::span<const uint32_t> nodes, GpuScene& gpu);
    // Puts nodes below another one (kNone: they become roots), before a child of it (kNone: at the end).
    // Where they are in the world stays, to rounding. No other scene of the file may lose them.
    void Reparent(std::span<const uint32_t> nodes, uint32_t parent, uint32_t before, GpuScene& gpu);
    // --- Images, each named by one of the textures that show it.
    //
    ImageFacts ImageOf(uint32_t texture) const;
    // Lets the textures that share the image of this one show the picture of a file, in one step of the
    // history. Throws Error{Io} or Error{BadInput} in one line if the file is no picture that LoadGltf reads,
    // and what GpuScene::Add throws; then nothing changes. What was replaced keeps its memory on the device.
    void ReplaceImage(uint32_t texture, const std::filesystem::path& file, GpuScene& gpu);
    // Returns a number that grows when a picture on the device is exchanged.
    uint64_t ImageRevision() const { return m_imageRevision; }
    const MeshFacts& FactsOfMesh(uint32_t mesh) const { return m_meshFacts.at(mesh); }
    // Returns the nodes that the last Undo or Redo has brought back.
    const std::vector<uint32_t>& Restored() const { return m_restored; }
    // Ends a step of the history: the next edit starts a new one.
    void Settle() { m_isOpen = false; }
    bool CanUndo() const { return m_done > 0; }
    bool CanRedo() const { return m_done < m_steps.size(); }
    // Shows the variant, here and on the device; scene::kNone: no variant. This is no edit, and no step of
    // the history.
    void ShowVariant(uint32_t variant, GpuScene& gpu);
    void Undo(GpuScene& gpu);
    void Redo(GpuScene& gpu);
    // Returns the number of edits that are in effect.
    size_t EditCount() const { return m_done; }
    // Returns a number that grows with every edit, undo and redo: equal counts are equal states.
    uint64_t ChangeCount() const { return m_changes; }
    // Returns whether the edits differ from those that were saved last.
    bool IsEdited() const { return m_done != m_saved; }
    // Writes the file with its edits to `to`, which may be the file itself and is the document's from then
    // on. Throws Error{BadInput} if the file has changed since it was loaded, and what scene::SaveGltf
    // throws.
    void Save(const std::filesystem::path& to);
    // Writes the file with its edits to a new one beside it, NAME-recovered.gltf or .glb, and returns the
    // path of that. The document stays as it is. Throws what SaveGltf throws.
    std::filesystem::path SaveRecoveryCopy() const;
    // Writes the file with its edits to `to`, which is not the file itself, and needs nothing outside of its
    // folder. The document stays as it is. Throws what SaveGltf throws.
    void SaveCopy(const std::filesystem::path& to) const { WriteFile(to, true); }
    // Identifies the content of the file, if the open scene equals it. The hash is unknown after edits were
    // saved. RecordContent stores the hash, unless the file has changed since.
    FileContent Content() const;
    void RecordContent(const FileContent& content);

  private:
    struct Step {
        std::vector<Edit> before, after;  // rest values, in the order in which they are put
    };
    // A node places these: a contiguous range of instances, a light and a camera; scene::kNone: none.
    struct Placed {
        uint32_t firstInstance = 0, instanceCount = 0, light = scene::kNone, camera = scene::kNone;

        uint32_t InstanceEnd() const { return firstInstance + instanceCount; }
    };
    // Holds the pictures that an image has had.
    struct EditedImage {
        struct Choice {
            ImageFacts facts;
            std::shared_ptr<const std::vector<std::byte>> bytes = {};  // of the file; null: the scene's own
            // The textures of the device that have its picture, by texture of the image.
            std::vector<uint32_t> textures = {};
        };
        std::vector<Choice> choices;
        uint32_t shown = 0, onDevice = 0;
    };
    void TakeImages(const scene::SceneData& data);
    void ShowImages(GpuScene& gpu);  // on the device
    std::vector<scene::ReplacedImage> ReplacedImages() const;
    // Returns the other scenes of the file that have the node.
    std::vector<size_t> OtherScenesWith(uint32_t node) const;
    // Returns whether a clip that is shown has a channel for the property.
    bool IsAnimated(scene::AnimatedProperty property, uint32_t object) const;
    // Returns the edit of rest values after which the values of `shown` are what is shown.
    Edit ToRestEdit(const Edit& shown) const;
    Edit ToRestEdit(const TransformEdit& shown) const;
    Edit Current(const Edit& of) const;
    // Throws if an animation overrides the value that was edited.
    void RequireShown(const Edit& edit) const;
    // Throws if the node would lose its area where it or a descendant places a mesh, or its inverse where one
    // places a light.
    void RequireValidPlacement(const TransformEdit& edit) const;
    // Makes edits of rest values, here and on the device, and returns those that undo them. On an error
    // nothing has changed.
    std::vector<Edit> Put(std::span<const Edit> edits, GpuScene& gpu);
    void Set(const Edit& edit);  // sets the rest values here
    // Updates the pose and the device.
    void Follow(std::span<const Edit> edits, GpuScene& gpu);
    void PutStep(const std::vector<Edit>& edits, GpuScene& gpu);  // of the history
    // Lists the nodes that are present, here and in the scenes.
    void UpdateOrder();
    std::vector<uint32_t>& SiblingsOf(uint32_t parent) {
        return parent == scene::kNone ? m_allRoots : m_allChildren[parent];
    }
    // Adds a node to the scenes that is not present, as the last child of its parent; `copied` is its
    // original, or kNone.
    uint32_t AddNode(scene::Node node, uint32_t copied);
    // Adds what `original` places to a copy of it.
    void CopyObjects(uint32_t original, uint32_t copy);
    // Calls `add`, which adds nodes and returns the uppermost ones, lets the device follow, and makes them
    // present.
    template <typename Nodes>
    std::vector<uint32_t> AddNodes(Nodes&& add, GpuScene& gpu);
    void WriteFile(const std::filesystem::path& to, bool isSelfContained = false) const;
    // Sends the changes to the device, or the whole scene if an earlier error has interrupted this.
    void Push(const scene::PoseChanges& changes, GpuScene& gpu);
    // Returns the node and its descendants, parents first.
    std::vector<uint32_t> Subtree(uint32_t node) const;

    std::filesystem::path m_file, m_root;
    std::optional<FileStamp> m_stamp;
    std::map<uint32_t, std::string> m_hashes;  // hash of the file's content by variant, where it is known
    scene::SceneData m_scene, m_rest;          // m_rest is empty without animations
    scene::PoseEvaluator m_evaluator{m_scene};
    scene::PoseApplier m_applier{m_scene};
    std::vector<scene::ClipState> m_clips;
    bool m_isDeviceStale = false;  // some changes are not on the device yet
    scene::SceneStatistics m_statistics;
    std::vector<std::vector<uint32_t>> m_children;
    std::vector<uint32_t> m_roots;
    // These hold all nodes, those that have been removed at their old places, too.
    std::vector<std::vector<uint32_t>> m_allChildren;
    std::vector<uint32_t> m_allRoots;
    std::vector<bool> m_isRemoved;  // indexed by node: itself
    std::vector<bool> m_isPlaced;   // indexed by node: neither removed nor below one that is
    std::vector<uint32_t> m_restored;
    // scene::SaveOrigin says what these are. The text is kept once a file has been written.
    std::string m_json;
    std::vector<std::byte> m_content;  // SaveOrigin::file, once a replaced image has been written
    std::vector<uint32_t> m_copiedFrom;
    std::vector<Placed> m_placed;        // indexed by node
    std::vector<bool> m_isJoint;         // indexed by the nodes of the file
    std::vector<bool> m_isNodeAnimated;  // some animation changes a part of its transform
    std::vector<EditedImage> m_images;   // by image of the scene
    uint64_t m_imageRevision = 0;
    std::vector<MeshFacts> m_meshFacts;
    std::vector<Step> m_steps;
    size_t m_saved = 0;  // m_done when the scene was saved; kNeverSaved: no state equals the saved one
    size_t m_done = 0;   // steps in effect; later ones can be redone
    uint64_t m_changes = 0;
    bool m_isOpen = false;  // the next edit may extend the last step
};

}  // namespace raygraph::editor
