// Shows the gizmo in the picture: draws the handles of the selection, and drags them. All selected nodes move
// about one pivot, each once: not again with one above it. A drag is one step of the history.
#pragma once

#include <imgui.h>

#include <optional>
#include <vector>

#include "editor/app/gizmo.h"
#include "editor/app/input.h"
#include "editor/app/workspace.h"

namespace raygraph::editor {

class GizmoView {
  public:
    // Starts, continues and ends drags of handles. `mouse` is in points from the picture's upper left corner,
    // `size` is its size in points; `mayTake`: the mouse is over the picture and free.
    void Update(Workspace& work, const FrameInput& input, glm::vec2 mouse, glm::vec2 size, bool mayTake);
    // Draws into the current ImGui window; `corner` is the picture's.
    void Draw(const Workspace& work, ImVec2 corner, glm::vec2 size) const;
    bool IsHeld() const { return m_drag.has_value(); }
    // Cancels the drag and restores the nodes. Returns false if nothing is being dragged.
    bool Cancel(Workspace& work);

  private:
    struct Dragged {
        uint32_t node;
        glm::mat4x3 parentToWorld, local;  // at the start of the drag
        bool isAboutOrigin;                // the pivot is the node's origin
    };
    struct Held {
        GizmoDrag drag;
        std::vector<uint32_t> selection;
        std::vector<Dragged> nodes;
        glm::vec3 pivot;  // in the space of the node that gives the frame
        GizmoTool tool;
        size_t editsBefore;
    };
    std::optional<GizmoFrame> FrameOfSelection(const Workspace& work, const PictureMap& map) const;

    std::optional<Held> m_drag;
    std::optional<GizmoHandle> m_over;
};

// Draws the buttons of the tools into the current ImGui window.
void GizmoButtons(Workspace& work);

}  // namespace raygraph::editor
