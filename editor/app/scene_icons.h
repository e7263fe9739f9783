// Icons of lights and cameras in the picture, which stand for what has no surface to click on. What is behind
// a wall has one, too. Threads: pure functions but DrawIcons; all on the main thread.
#pragma once

#include <imgui.h>

#include <optional>
#include <vector>

#include "editor/app/gizmo.h"
#include "editor/app/workspace.h"

namespace raygraph::editor {

struct SceneIcon {
    uint32_t node = 0;
    std::optional<scene::LightType> light;  // none: a camera
    glm::vec2 place{0.0f};                  // points from the picture's upper left corner
    float depth = 0.0f;                     // meters along the line of sight
    glm::vec2 direction{0.0f};              // of light or view, in the picture; at most of length 1
};
// Returns the icons in front of the eye, from the farthest to the nearest. None if they are switched off, or
// if two views are side by side.
std::vector<SceneIcon> IconsOf(const Workspace& work, const PictureMap& map);
// Returns the node of the nearest icon at a place; nullopt if there is none.
std::optional<uint32_t> IconAt(const std::vector<SceneIcon>& icons, glm::vec2 place);
// Draws into the current ImGui window, over the picture of this corner and size in points.
void DrawIcons(const Workspace& work, ImVec2 corner, glm::vec2 size);

}  // namespace raygraph::editor
