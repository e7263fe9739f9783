// The open scene as the editor knows it: names, hierarchy and all that can be edited, beside the GpuScene
// that shows it. Every edit goes through Apply, and can be undone.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::editor {

// What a node, material or light becomes. Indices are those of SceneData.
struct TransformEdit {
    uint32_t node = 0;
    glm::mat4x3 local{1.0f};
};
struct MaterialEdit {
    uint32_t material = 0;
    scene::Material values;
};
struct LightEdit {
    uint32_t light = 0;
    scene::Light values;
};
using Edit = std::variant<TransformEdit, MaterialEdit, LightEdit>;

class Document {
  public:
    Document() = default;  // an empty scene without a file
    // All of `data` but the vertices, the texels and what else only the device needs.
    Document(std::filesystem::path file, const scene::SceneData& data);

    const std::filesystem::path& File() const { return m_file; }
    // Without vertex streams and images; bounds and names are there.
    const scene::SceneData& Scene() const { return m_scene; }
    const scene::SceneStatistics& Statistics() const { return m_statistics; }
    const std::vector<std::vector<uint32_t>>& Children() const { return m_children; }  // by node
    const std::vector<uint32_t>& Roots() const { return m_roots; }
    // Of a node and all below it, world space.
    scene::Bounds BoundsOf(uint32_t node) const;
    // The nodes that the instance's node lies under, itself first.
    bool IsUnder(uint32_t node, uint32_t ancestor) const;

    // Makes the edit, here and on the device. Edits of one thing that follow each other before Settle are one
    // step of the history, as while a slider is dragged.
    void Apply(const Edit& edit, GpuScene& gpu);
    // What comes next is a step of its own.
    void Settle() { m_isOpen = false; }
    bool CanUndo() const { return m_done > 0; }
    bool CanRedo() const { return m_done < m_steps.size(); }
    void Undo(GpuScene& gpu);
    void Redo(GpuScene& gpu);
    // Edits made and not undone, for the title.
    size_t EditCount() const { return m_done; }

  private:
    struct Step {
        Edit before, after;
    };
    Edit Current(const Edit& of) const;
    void Put(const Edit& edit, GpuScene& gpu);
    void PutTransform(const TransformEdit& edit, GpuScene& gpu);

    std::filesystem::path m_file;
    scene::SceneData m_scene;
    scene::SceneStatistics m_statistics;
    std::vector<std::vector<uint32_t>> m_children;
    std::vector<uint32_t> m_roots;
    std::vector<Step> m_steps;
    size_t m_done = 0;      // steps that are in effect; those after it can be redone
    bool m_isOpen = false;  // the last step may go on
};

}  // namespace raygraph::editor
