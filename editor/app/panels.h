// The panels around the picture. Each draws into the current ImGui window, and edits the workspace.
#pragma once

#include <imgui.h>

#include "editor/app/actions.h"
#include "editor/app/workspace.h"
#include "shaders/shared/choice.h"

namespace raygraph::editor {

// Chooses a value of an enumeration with texts (RAYGRAPH_CHOICE) from a list.
template <typename Choice>
void Choose(const char* label, Choice& value) {
    static constexpr auto kTexts = Texts(Choice{});
    int index = static_cast<int>(value);
    if (ImGui::Combo(label, &index, kTexts.data(), static_cast<int>(kTexts.size())))
        value = static_cast<Choice>(index);
}

// Returns the item width (ImGui::PushItemWidth) that leaves a panel room for its labels.
float WidthBesideLabels();

// Returns the keys as a menu shows them: its columns have hardly a gap.
inline std::string MenuKey(const std::string& keys) {
    return "   " + keys;
}

void HierarchyPanel(Workspace& work);
// Moves the selection from row to row, opens and closes rows, or ends the search. Returns false if the key is
// none of the hierarchy's, or if its panel has not been clicked last.
bool HierarchyKey(Workspace& work, const KeyPress& press);
// Edits transform, material and light of the selection.
void InspectorPanel(Workspace& work);
// Edits a color: linear numbers, and a swatch that shows it as the screen does and opens a picker, whose
// numbers and hexadecimal digits are sRGB's. Returns true if it was edited.
bool ColorFields(const char* label, glm::vec3& linear);
// Edits view, exposure, tone mapping, environment, and path tracing.
void SettingsPanel(Workspace& work);
// Edits the camera's field of view and lens.
void LensFields(Workspace& work);
// Edits the white point.
void WhitePointField(Workspace& work);
// Controls clips, time and speed of the animations.
void TimelinePanel(Workspace& work);
// Shows samples, times of the passes, memory, acceleration structures.
void StatisticsPanel(Workspace& work);
// Draws the plan of the last frame.
void GraphPanel(Workspace& work);
// Lists the newest messages, filtered.
void LogPanel(Workspace& work);
// Shows the path of a pixel (ExplainedPixel) as a table of its vertices.
void PathPanel(Workspace& work);
// Draws that path into the current ImGui window, over the picture of this corner and size in points.
void DrawPath(const Workspace& work, ImVec2 corner, glm::vec2 size);
// Draws the handle of the wipe, which can be dragged, and the scale of error views, likewise.
void DrawComparison(Workspace& work, ImVec2 corner, glm::vec2 size);
// Draws a text that can be read over any picture; `at` is its corner on the screen.
void TextOverPicture(ImVec2 at, const char* text);
// Lists what mouse and keys do; a click on a key binds another one.
void HelpPanel(Workspace& work);

}  // namespace raygraph::editor
