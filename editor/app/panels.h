// The panels around the picture. Each draws into the current ImGui window, and edits the workspace.
#pragma once

#include "editor/app/workspace.h"

namespace raygraph::editor {

void HierarchyPanel(Workspace& work);
// Transform, material and light of the selection.
void InspectorPanel(Workspace& work);
// View, exposure and tone mapping, environment, how paths are traced.
void SettingsPanel(Workspace& work);
// Clips, time and speed of the animations.
void TimelinePanel(Workspace& work);
// Samples, times of the passes, memory, acceleration structures.
void StatisticsPanel(Workspace& work);
// The plan of the last frame.
void GraphPanel(Workspace& work);
// The newest messages, filtered.
void LogPanel(Workspace& work);
void HelpPanel();

}  // namespace raygraph::editor
