// How the scene is shown, and what it costs: settings, statistics, graph and help.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <glm/gtc/type_ptr.hpp>
#include <string>

#include "editor/app/panels.h"

namespace raygraph::editor {

namespace {

#define RAYGRAPH_NAME(name, value) #name,
constexpr std::array kOperators{RAYGRAPH_TONEMAP_OPERATORS(RAYGRAPH_NAME)};
#undef RAYGRAPH_NAME

template <typename Enum, size_t Count>
bool Choose(const char* label, Enum& value, const std::array<const char*, Count>& names) {
    int index = static_cast<int>(value);
    if (!ImGui::Combo(label, &index, names.data(), static_cast<int>(Count))) return false;
    value = static_cast<Enum>(index);
    return true;
}

std::string BytesText(uint64_t bytes) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) / (1 << 20));
    return text;
}

void Row(const char* name, const std::string& value) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextDisabled("%s", name);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(value.c_str());
}

}  // namespace

void SettingsPanel(Workspace& work) {
    ImGui::PushItemWidth(-90.0f);
    viewport::ShowSettings show = work.view.Show();
    std::array<const char*, viewport::kViewCount> views{};
    for (uint32_t i = 0; i < viewport::kViewCount; i++) views[i] = Name(static_cast<viewport::View>(i));
    Choose("view", show.view, views);
    if (show.view == viewport::View::Wipe) ImGui::SliderFloat("wipe", &show.wipePosition, 0.0f, 1.0f);
    if (show.view == viewport::View::RelativeError)
        ImGui::SliderFloat("error", &show.greatestError, 0.01f, 2.0f, "%.2f",
                           ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
    ImGui::SliderFloat("exposure", &show.tonemap.exposureEv, -8.0f, 8.0f, "%+.1f EV",
                       ImGuiSliderFlags_AlwaysClamp);
    Choose("tone", show.tonemap.tonemapOperator, kOperators);
    if (!(show == work.view.Show())) work.view.SetShow(show);

    ImGui::Separator();
    EnvironmentSettings environment = work.gpu.Environment();
    bool isEdited = ImGui::ColorEdit3("sky", glm::value_ptr(environment.radiance),
                                      ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR);
    isEdited |= ImGui::SliderAngle("turn", &environment.rotation, -180.0f, 180.0f);
    environment.radiance = glm::clamp(environment.radiance, glm::vec3(0.0f), glm::vec3(1e6f));
    if (isEdited) work.gpu.SetEnvironment(environment);

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

void StatisticsPanel(Workspace& work) {
    const viewport::ViewportProgress progress = work.view.Progress();
    const GpuSceneStatistics& scene = work.gpu.Statistics();
    if (ImGui::BeginTable("statistics", 2, ImGuiTableFlags_SizingFixedFit)) {
        Row("device", work.device.Info().name);
        Row("samples", std::to_string(progress.pathTracedSamples) + " path-traced, " +
                           std::to_string(progress.rasterSamples) + " raster");
        Row("triangles", std::to_string(scene.trianglesPlaced) + " in " +
                             std::to_string(scene.instanceCount) + " instances");
        Row("lights", std::to_string(scene.lightCount));
        Row("BLAS", std::to_string(scene.blasCount) + ", " + BytesText(scene.blasBytesCompacted));
        Row("TLAS", std::to_string(scene.tlasRebuilds) + " builds, " + std::to_string(scene.tlasUpdates) +
                        " updates, " + BytesText(scene.tlasBytes));
        Row("memory", BytesText(work.device.Memory().usedBytes) + ", peak " +
                          BytesText(work.device.Memory().peakBytes));
        ImGui::EndTable();
    }
    const FrameTiming& timing = work.renderer.Timing();
    double total = 0.0;
    for (const PassTiming& pass : timing.passes) total += pass.gpuMs;
    ImGui::Text("frame %.2f ms", total);
    for (const PassTiming& pass : timing.passes) {
        char text[96];
        std::snprintf(text, sizeof text, "%s  %.3f ms", pass.name.c_str(), pass.gpuMs);
        ImGui::ProgressBar(total > 0.0 ? static_cast<float>(pass.gpuMs / total) : 0.0f, {-1.0f, 0.0f}, text);
    }
}

void GraphPanel(Workspace& work) {
    const std::string plan = work.renderer.DescribePlan();
    ImGui::BeginChild("plan", {0.0f, 0.0f}, false, ImGuiWindowFlags_HorizontalScrollbar);
    ImGui::TextUnformatted(plan.c_str(), plan.c_str() + plan.size());
    ImGui::EndChild();
}

void HelpPanel() {
    constexpr std::array<std::array<const char*, 2>, 20> kKeys{{
        {"left drag", "orbit"},
        {"middle drag, Shift + left drag", "pan"},
        {"wheel", "closer, farther"},
        {"right drag", "look around; with W A S D Q E fly (Shift: fast, Ctrl: slow)"},
        {"click", "select what is there"},
        {"F", "frame the selection, or all"},
        {"R", "raster or path-traced"},
        {"Tab", "next view"},
        {"W", "wipe between raster and path-traced"},
        {"1 to 9", "camera bookmark; Ctrl + 1 to 9 sets it"},
        {"Home", "the scene's camera"},
        {"Ctrl + O", "open a scene"},
        {"Ctrl + Q", "quit"},
        {"Ctrl + Z", "undo"},
        {"Ctrl + Y, Ctrl + Shift + Z", "redo"},
        {"G", "the frame's plan"},
        {"T", "statistics"},
        {"F5", "reload shaders"},
        {"F12", "save the picture"},
        {"F1", "this help"},
    }};
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
