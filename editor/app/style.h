// Styles the user interface, and feeds it keys.
#pragma once

#include <imgui.h>

#include "editor/app/input.h"

namespace raygraph::editor {

// Sets a dark, neutral style with one accent, which does not bias the judgement of a picture's color. Sizes
// are in points.
void ApplyStyle(ImGuiStyle& style);

// Passes keys to ImGui, for text fields and for shortcuts of its widgets.
void FeedKeys(ImGuiIO& io, const FrameInput& input);

}  // namespace raygraph::editor
