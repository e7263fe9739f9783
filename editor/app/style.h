// How the user interface looks, and how keys reach it.
#pragma once

#include <imgui.h>

#include "editor/app/input.h"

namespace raygraph::editor {

// Dark and neutral, so that it does not color the judgement of a picture; one accent. Sizes in points.
void ApplyStyle(ImGuiStyle& style);

// Keys as ImGui's own, for text fields and shortcuts of its widgets.
void FeedKeys(ImGuiIO& io, const FrameInput& input);

}  // namespace raygraph::editor
