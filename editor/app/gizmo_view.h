// The gizmo in the picture: draws the handles of what is selected, and drags them. A drag is one step of the
// history.
#pragma once

#include <imgui.h>

#include <optional>

#include "editor/app/gizmo.h"
#include "editor/app/input.h"
#include "editor/app/workspace.h"

namespace raygraph::editor {

class GizmoView {
  public:
    // Takes, drags and lets go of handles. `mouse`: points from the picture's upper left corner; `size` its
    // size in points; `mayTake`: the mouse is over the picture and free.
    void Update(Workspace& work, const FrameInput& input, glm::vec2 mouse, glm::vec2 size, bool mayTake);
    // Into the ImGui window at hand; `corner` is that of the picture.
    void Draw(const Workspace& work, ImVec2 corner, glm::vec2 size) const;
    bool IsHeld() const { return m_drag.has_value(); }
    // Puts what is held back to where it was. False: nothing is held.
    bool Cancel(Workspace& work);

  private:
    struct Held {
        GizmoDrag drag;
        uint32_t node;
        glm::mat4x3 parentToWorld, local;  // at the start
        glm::vec3 pivot;                   // in the node's space
        size_t editsBefore;
    };
    std::optional<GizmoFrame> FrameOfSelection(const Workspace& work, const PictureMap& map) const;

    std::optional<Held> m_drag;
    std::optional<GizmoHandle> m_over;
};

// Buttons for the tools, into the ImGui window at hand.
void GizmoButtons(Workspace& work);

}  // namespace raygraph::editor
