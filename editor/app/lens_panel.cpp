// Draws the camera's field of view, its lens and the white point.
#include <imgui.h>

#include <algorithm>

#include "editor/app/panels.h"
#include "editor/app/settings.h"

namespace raygraph::editor {

namespace {

constexpr float kMinDegrees = 1.0f, kMaxDegrees = 170.0f;  // vertical field of view
constexpr float kMaxAperture = 1e6f, kMaxFocus = 1e9f;     // meters, as `render` takes them
constexpr ImGuiSliderFlags kExact = ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat;

// Returns the change of a length for each point that the mouse is dragged.
float DragSpeed(float meters) {
    return 0.005f * std::max(meters, 1e-6f);
}

void ProjectionField(Workspace& work) {
    scene::CameraView view = work.camera.View();
    bool isEdited = false;
    if (view.projection == scene::Projection::Orthographic) {
        isEdited =
            ImGui::DragFloat("height", &view.height, DragSpeed(view.height), 1e-6f, 1e9f, "%.4g m", kExact);
    } else {
        float degrees = glm::degrees(view.yFov);
        isEdited = ImGui::DragFloat("fov", &degrees, 0.1f, kMinDegrees, kMaxDegrees, "%.2f deg",
                                    ImGuiSliderFlags_AlwaysClamp);
        view.yFov = glm::radians(degrees);
    }
    if (isEdited) work.camera.Set(view, work.camera.Distance());
}

}  // namespace

void LensFields(Workspace& work) {
    ProjectionField(work);
    ImGui::BeginDisabled(work.camera.View().projection == scene::Projection::Orthographic);
    float focus = work.FocusDistance();
    ImGui::DragFloat("aperture", &work.aperture, DragSpeed(0.01f * focus), 0.0f, kMaxAperture, "%.4g m",
                     kExact);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("radius of the lens; 0: all is sharp");
    const float button = ImGui::CalcTextSize("pick").x + 2.0f * ImGui::GetStyle().FramePadding.x;
    const float space = ImGui::GetStyle().ItemInnerSpacing.x;
    ImGui::SetNextItemWidth(ImGui::CalcItemWidth() - button - space);
    if (ImGui::DragFloat("##focus", &focus, DragSpeed(focus), 1e-6f, kMaxFocus, "%.4g m", kExact))
        work.focus = focus;
    ImGui::SameLine(0.0f, space);
    const bool isPicking = work.IsPickingFocus();
    if (isPicking) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
    if (ImGui::Button("pick")) work.PickFocus(!isPicking);
    if (isPicking) ImGui::PopStyleColor();
    ImGui::SameLine(0.0f, space);
    ImGui::TextUnformatted("focus");
    ImGui::EndDisabled();
}

void WhitePointField(Workspace& work) {
    int kelvin = work.WhitePoint();
    if (ImGui::DragInt("white", &kelvin, 10.0f, static_cast<int>(kWhitePointRange.min),
                       static_cast<int>(kWhitePointRange.max), "%d K", ImGuiSliderFlags_AlwaysClamp))
        work.SetWhitePoint(kelvin);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("a light of this temperature is shown as white");
}

}  // namespace raygraph::editor
