// Icons of the hierarchy's rows, drawn by lines. Main thread only.
#pragma once

#include <imgui.h>

#include "editor/app/document.h"

namespace raygraph::editor {

// Draws an icon of at most 14 by 14 points around `center`.
void DrawNodeIcon(ImDrawList& list, NodeKind kind, ImVec2 center, ImU32 color);
// Draws an eye of that size.
void DrawEye(ImDrawList& list, bool isOpen, ImVec2 center, ImU32 color);

}  // namespace raygraph::editor
