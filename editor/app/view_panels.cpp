// Draws the panels about how the scene is shown, and the help.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <string>

#include "editor/app/actions.h"
#include "editor/app/panels.h"
#include "editor/app/settings.h"

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
    const std::string file = work.EnvironmentFile().filename().string();
    const bool isStudio = work.gpu.ShownEnvironment().defaultLight == DefaultLight::Studio;
    // Without an environment to tint, the sky is one color
    if (environment.usesScene && !isStudio && !work.HasSceneEnvironment())
        environment = {.radiance = glm::vec3(0.0f), .rotation = environment.rotation};
    // The brightest channel is the intensity; the rest is the color
    float intensity = std::max({environment.radiance.x, environment.radiance.y, environment.radiance.z});
    glm::vec3 color = intensity > 0.0f ? environment.radiance / intensity : glm::vec3(1.0f);
    if (file.empty()) {
        ImGui::TextDisabled("sky: %s; drop an .hdr or .exr", isStudio                ? "studio"
                                                             : environment.usesScene ? "the scene's"
                                                                                     : "one color");
        DefaultLight light = work.Light();
        Choose("studio", light);
        if (light != work.Light()) work.UseLight(light);
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
    if (show.view == viewport::View::Wipe)
        ImGui::SliderFloat("wipe", &show.wipePosition, kWipeRange.min, kWipeRange.max);
    if (show.view == viewport::View::RelativeError)
        ImGui::SliderFloat("error", &show.maxError, kErrorRange.min, kErrorRange.max, "%.2f",
                           ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
    ImGui::SliderFloat("exposure", &show.tonemap.exposureEv, kExposureRange.min, kExposureRange.max,
                       "%+.1f EV", ImGuiSliderFlags_AlwaysClamp);
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
    constexpr float kOff = -std::numeric_limits<float>::infinity();
    passes::RasterSettings raster = work.view.Raster();
    bool makesMipLevels = paths.biases.textureLod > kOff;
    if (ImGui::Checkbox("mip levels", &makesMipLevels)) {
        paths.biases.textureLod = makesMipLevels ? 0.0f : kOff;
        raster.hasTextureLevels = makesMipLevels;
    }
    if (makesMipLevels)
        ImGui::SliderFloat("level", &paths.biases.textureLod, -4.0f, 4.0f, "%+.1f",
                           ImGuiSliderFlags_AlwaysClamp);
    if (!(paths == work.view.Paths())) work.view.SetPaths(paths);
    if (!(raster == work.view.Raster())) work.view.SetRaster(raster);
    ImGui::PopItemWidth();
}

void HelpPanel() {
    if (!ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) return;
    for (const auto& [key, what] : HelpRows()) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(key.c_str());
        ImGui::TableNextColumn();
        ImGui::TextDisabled("%s", what.c_str());
    }
    ImGui::EndTable();
}

}  // namespace raygraph::editor
