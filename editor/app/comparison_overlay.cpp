// Draws what comparisons need over the picture: the handle of the wipe, and the scale of errors.
#include <imgui.h>

#include <algorithm>
#include <glm/glm.hpp>
#include <string>

#include "base/text.h"
#include "editor/app/panels.h"
#include "editor/app/settings.h"
#include "shaders/core/ramp.glsl"

namespace raygraph::editor {

namespace {

constexpr float kReach = 5.0f;  // points beside the line
constexpr ImU32 kBehindText = IM_COL32(20, 20, 20, 190), kText = IM_COL32(240, 240, 240, 255);

void DragWipe(Workspace& work, ImVec2 corner, glm::vec2 size) {
    viewport::ShowSettings show = work.view.Show();
    const float x = corner.x + size.x * std::clamp(show.wipePosition, 0.0f, 1.0f);
    ImGui::SetCursorScreenPos({x - kReach, corner.y});
    ImGui::InvisibleButton("wipe", {2.0f * kReach, std::max(size.y, 1.0f)});
    const bool isHeld = ImGui::IsItemActive();
    if (!isHeld && !ImGui::IsItemHovered()) return;
    ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    ImGui::GetWindowDrawList()->AddLine({x, corner.y}, {x, corner.y + size.y}, kText, 2.0f);
    if (!isHeld) return;
    show.wipePosition = std::clamp((ImGui::GetIO().MousePos.x - corner.x) / size.x, 0.0f, 1.0f);
    if (!(show == work.view.Show())) work.view.SetShow(show);
}

ImU32 ColorAt(float t) {
    const glm::vec3 color = shading::SrgbEncode(shading::HeatColor(t));
    return ImGui::ColorConvertFloat4ToU32({color.x, color.y, color.z, 1.0f});
}

// Draws the colors from 0 to `most` in the lower right corner.
void ErrorScale(ImVec2 corner, glm::vec2 size, const char* name, const std::string& most) {
    constexpr int kSteps = 24;
    const float width = std::min(200.0f, 0.5f * size.x), line = ImGui::GetTextLineHeight();
    const ImVec2 pad = ImGui::GetStyle().FramePadding;
    const ImVec2 from{corner.x + size.x - width - 12.0f, corner.y + size.y - 2.0f * line - 16.0f};
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled({from.x - pad.x, from.y - pad.y},
                       {from.x + width + pad.x, from.y + 2.0f * line + 4.0f}, kBehindText, 3.0f);
    for (int i = 0; i < kSteps; ++i) {
        const float begin = static_cast<float>(i) / kSteps, end = static_cast<float>(i + 1) / kSteps;
        const ImU32 left = ColorAt(begin), right = ColorAt(end);
        list.AddRectFilledMultiColor({from.x + width * begin, from.y}, {from.x + width * end, from.y + line},
                                     left, right, right, left);
    }
    const float below = from.y + line + 1.0f, middle = 0.5f * (width - ImGui::CalcTextSize(name).x);
    list.AddText({from.x, below}, kText, "0");
    list.AddText({from.x + middle, below}, kText, name);
    list.AddText({from.x + width - ImGui::CalcTextSize(most.c_str()).x, below}, kText, most.c_str());
}

}  // namespace

void TextOverPicture(ImVec2 at, const char* text) {
    const ImVec2 size = ImGui::CalcTextSize(text), pad = ImGui::GetStyle().FramePadding;
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled({at.x - pad.x, at.y - pad.y}, {at.x + size.x + pad.x, at.y + size.y + pad.y},
                       kBehindText, 3.0f);
    list.AddText(at, kText, text);
}

void DrawComparison(Workspace& work, ImVec2 corner, glm::vec2 size) {
    const viewport::ShowSettings& show = work.view.Show();
    if (show.view == viewport::View::Wipe) DragWipe(work, corner, size);
    if (show.view == viewport::View::RelativeError)
        ErrorScale(corner, size, "relative error", Text("{:.3g}", show.maxError));
    if (show.view == viewport::View::Flip) ErrorScale(corner, size, "FLIP", "1");
}

}  // namespace raygraph::editor
