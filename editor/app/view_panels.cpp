// How the scene is shown, and help.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <glm/gtc/type_ptr.hpp>
#include <string>

#include "editor/app/panels.h"

namespace raygraph::editor {

namespace {

template <typename Choice>
void Choose(const char* label, Choice& value) {
    static constexpr auto kTexts = Texts(Choice{});
    int index = static_cast<int>(value);
    if (ImGui::Combo(label, &index, kTexts.data(), static_cast<int>(kTexts.size())))
        value = static_cast<Choice>(index);
}

void EnvironmentFields(Workspace& work) {
    EnvironmentSettings environment = work.gpu.Environment();
    // The brightest channel is the intensity, the rest is the color
    float intensity = std::max({environment.radiance.x, environment.radiance.y, environment.radiance.z});
    glm::vec3 color = intensity > 0.0f ? environment.radiance / intensity : glm::vec3(1.0f);
    const std::string file = work.EnvironmentFile().filename().string();
    if (file.empty()) {
        ImGui::TextDisabled("sky: one colour; drop an .hdr or .exr");
    } else {
        ImGui::TextUnformatted(file.c_str());
        ImGui::SameLine();
        if (ImGui::SmallButton("remove")) work.RemoveEnvironmentMap();
    }
    bool isEdited = ImGui::ColorEdit3("sky", glm::value_ptr(color), ImGuiColorEditFlags_Float);
    isEdited |=
        ImGui::DragFloat("intensity", &intensity, 0.01f, 0.0f, 1e6f, "%.3f", ImGuiSliderFlags_AlwaysClamp);
    isEdited |= ImGui::SliderAngle("turn", &environment.rotation, -180.0f, 180.0f);
    environment.radiance = glm::clamp(color, glm::vec3(0.0f), glm::vec3(1.0f)) * intensity;
    if (isEdited) work.gpu.SetEnvironment(environment);
}

}  // namespace

void SettingsPanel(Workspace& work) {
    ImGui::PushItemWidth(-90.0f);
    viewport::ShowSettings show = work.view.Show();
    Choose("view", show.view);
    if (show.view == viewport::View::Wipe) ImGui::SliderFloat("wipe", &show.wipePosition, 0.0f, 1.0f);
    if (show.view == viewport::View::RelativeError)
        ImGui::SliderFloat("error", &show.greatestError, 0.01f, 2.0f, "%.2f",
                           ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
    ImGui::SliderFloat("exposure", &show.tonemap.exposureEv, -8.0f, 8.0f, "%+.1f EV",
                       ImGuiSliderFlags_AlwaysClamp);
    Choose("tone", show.tonemap.tonemapOperator);
    if (!(show == work.view.Show())) work.view.SetShow(show);

    ImGui::Separator();
    EnvironmentFields(work);

    ImGui::Separator();
    viewport::PathSettings paths = work.view.Paths();
    ImGui::Checkbox("sample lights", &paths.lights.isOn);
    bool isLimited = paths.biases.maxDepth != passes::kNoDepthLimit;
    if (ImGui::Checkbox("limit bounces", &isLimited))
        paths.biases.maxDepth = isLimited ? 8 : passes::kNoDepthLimit;
    if (isLimited) {
        int depth = static_cast<int>(paths.biases.maxDepth);
        if (ImGui::SliderInt("bounces", &depth, 0, 32, "%d", ImGuiSliderFlags_AlwaysClamp))
            paths.biases.maxDepth = static_cast<uint32_t>(depth);
    }
    if (!(paths == work.view.Paths())) work.view.SetPaths(paths);
    ImGui::PopItemWidth();
}

void HelpPanel() {
    static constexpr auto kKeys = std::to_array<std::array<const char*, 2>>({
        {"left drag", "orbit; on a handle of the selection: move, rotate or scale it (Ctrl: in steps)"},
        {"middle drag, Shift + left drag", "pan"},
        {"wheel", "closer, farther"},
        {"right drag", "look around; with W A S D Q E fly (Shift: fast, Ctrl: slow)"},
        {"click", "select what is there"},
        {"Z, X, C", "handles that move, rotate, scale"},
        {"V", "their axes: the world's or the node's own"},
        {"P", "where they are: the middle of what is selected or its origin"},
        {"Escape", "give up the drag; else select nothing"},
        {"F", "frame the selection, or all"},
        {"Home", "the scene's camera"},
        {"1 to 9", "camera bookmark; Ctrl + 1 to 9 sets it"},
        {"R", "raster or path-traced"},
        {"Tab", "next view"},
        {"W", "wipe between raster and path-traced"},
        {"T, G", "statistics; the frame's plan"},
        {"Ctrl + O", "open a scene or an environment"},
        {"Ctrl + S", "save the picture as .png or .exr"},
        {"Ctrl + Shift + S", "save the scene with its edits"},
        {"Ctrl + Z", "undo"},
        {"Ctrl + Y, Ctrl + Shift + Z", "redo"},
        {"Ctrl + Q", "quit"},
        {"F5", "reload shaders"},
        {"F12", "screenshot: raygraph.png"},
        {"F1", "this help"},
    });
    if (!ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) return;
    for (const auto& [key, what] : kKeys) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(key);
        ImGui::TableNextColumn();
        ImGui::TextDisabled("%s", what);
    }
    ImGui::EndTable();
}

}  // namespace raygraph::editor
