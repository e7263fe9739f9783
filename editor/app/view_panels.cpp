// Draws the panels about how the scene is shown, and the help.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "base/text.h"
#include "editor/app/actions.h"
#include "editor/app/panels.h"
#include "editor/app/settings.h"
#include "editor/app/timeline.h"

namespace raygraph::editor {

namespace {

void ChooseSurface(passes::View& surface) {
    if (!ImGui::BeginCombo("surface", Name(surface))) return;
    for (const passes::View view : Values<passes::View>())
        if (!passes::ShowsLight(view) && ImGui::Selectable(Name(view), view == surface)) surface = view;
    ImGui::EndCombo();
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
    bool isEdited = ColorFields("sky", color);
    isEdited |=
        ImGui::DragFloat("intensity", &intensity, 0.01f, 0.0f, 1e6f, "%.3f", ImGuiSliderFlags_AlwaysClamp);
    isEdited |= ImGui::SliderAngle("turn", &environment.rotation, -180.0f, 180.0f);
    environment.radiance = glm::clamp(color, glm::vec3(0.0f), glm::vec3(1.0f)) * intensity;
    if (isEdited) work.gpu.SetEnvironment(environment);
}

// Says what is behind the scene: `render --backdrop`.
#define RAYGRAPH_BACKDROP_KINDS(X, Of)           \
    X(Of, Environment, 0, "environment", "")     \
    X(Of, Blurred, 1, "blurred environment", "") \
    X(Of, Color, 2, "a color", "")               \
    X(Of, Transparent, 3, "nothing: transparent", "")
RAYGRAPH_CHOICE(BackdropKind, RAYGRAPH_BACKDROP_KINDS)

void BackdropFields(Workspace& work) {
    std::optional<passes::BackdropSettings>& backdrop = work.backdrop;
    const BackdropKind before = !backdrop                      ? BackdropKind::Transparent
                                : backdrop->color              ? BackdropKind::Color
                                : backdrop->blurDegrees > 0.0f ? BackdropKind::Blurred
                                                               : BackdropKind::Environment;
    BackdropKind kind = before;
    Choose("behind", kind);
    if (kind != before) {
        backdrop.reset();
        if (kind != BackdropKind::Transparent) backdrop.emplace();
        if (kind == BackdropKind::Blurred) backdrop->blurDegrees = 10.0f;
        if (kind == BackdropKind::Color) backdrop->color = glm::vec3(1.0f);
    }
    if (kind == BackdropKind::Blurred)
        ImGui::DragFloat("blur", &backdrop->blurDegrees, 0.1f, 0.5f, 90.0f, "%.1f deg",
                         ImGuiSliderFlags_AlwaysClamp);
    if (kind == BackdropKind::Color && ColorFields("color", *backdrop->color))
        *backdrop->color = glm::clamp(*backdrop->color, glm::vec3(0.0f), glm::vec3(1.0f));
    ImGui::Checkbox("ground", &work.hasGround);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("shows the shadow on a ground below the scene");
}

}  // namespace

void SettingsPanel(Workspace& work) {
    ImGui::PushItemWidth(WidthBesideLabels());
    viewport::ShowSettings show = work.view.Show();
    Choose("view", show.view);
    if (show.view == viewport::View::PathTraced) {
        ImGui::Checkbox("denoise", &show.isDenoised);
        viewport::BudgetSettings budget = work.view.Budget();
        Choose("moving", budget.whileMoving);
        if (ImGui::IsItemHovered())
            ImGui::SetTooltip(
                "the view while something moves; automatic: raster where path-traced pixels would be coarse");
        if (!(budget == work.view.Budget())) work.view.SetBudget(budget);
    }
    if (show.view == viewport::View::Surface) ChooseSurface(show.surface);
    if (viewport::IsComparison(show.view)) Choose("compared", show.compared);
    if (show.view == viewport::View::Wipe)
        ImGui::SliderFloat("wipe", &show.wipePosition, kWipeRange.min, kWipeRange.max);
    if (show.view == viewport::View::RelativeError)
        ImGui::SliderFloat("error", &show.maxError, kErrorRange.min, kErrorRange.max, "%.2f",
                           ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
    ImGui::SliderFloat("exposure", &show.tonemap.exposureEv, kExposureRange.min, kExposureRange.max,
                       "%+.1f EV", ImGuiSliderFlags_AlwaysClamp);
    Choose("tone", show.tonemap.tonemapOperator);
    if (!(show == work.view.Show())) work.view.SetShow(show);
    WhitePointField(work);

    ImGui::Separator();
    LensFields(work);

    ImGui::Separator();
    EnvironmentFields(work);
    BackdropFields(work);

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

void HelpPanel(Workspace& work) {
    KeyPreset preset = work.keys.Preset();
    ImGui::SetNextItemWidth(140.0f);
    Choose("keys", preset);
    if (preset != work.keys.Preset()) work.keys = KeyBindings(preset);
    ImGui::SameLine();
    ImGui::TextDisabled("%s", work.actionToBind ? "press a key; Escape: as it was; Delete: none"
                                                : "click on a key to choose another one");
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const ImVec2 size{std::min(820.0f, 0.95f * display.x), std::min(620.0f, 0.75f * display.y)};
    if (!ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_ScrollY, size)) return;
    const auto help = [](const char* text) {
        ImGui::TableNextColumn();
        ImGui::AlignTextToFramePadding();
        ImGui::TextDisabled("%s", text);
    };
    for (const auto& [gesture, what] : GestureRows(preset)) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::AlignTextToFramePadding();
        ImGui::TextUnformatted(gesture.c_str());
        help(what.c_str());
    }
    for (const ActionRow& row : Actions()) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        const std::string keys = work.actionToBind == row.action ? "..." : work.keys.TextOf(row.action);
        if (ImGui::Button((keys + "##" + row.name).c_str(), {170.0f, 0.0f})) work.actionToBind = row.action;
        help(row.help);
    }
    ImGui::EndTable();
}

// --- The timeline below the picture: the clips, the time, and playback ---

namespace {

constexpr float kButton = 56.0f;  // points
constexpr float kSpeed = 90.0f;

// Chooses a single clip, all of them, or some blended by weights.
void ClipChoice(Timeline& timeline) {
    if (!ImGui::BeginCombo("##clips", timeline.ClipsLabel().c_str(), ImGuiComboFlags_HeightLarge)) return;
    const std::span<const Timeline::Clip> clips = timeline.Clips();
    size_t onCount = 0;
    for (const Timeline::Clip& clip : clips) onCount += clip.isOn ? 1 : 0;
    const auto choice = [&](size_t index) {
        const Timeline::Clip& clip = clips[index];
        const std::string label = Text("{}  {:.2f} s##{}", clip.name, clip.seconds, index);
        if (ImGui::Selectable(label.c_str(), onCount == 1 && clip.isOn)) timeline.ChooseOnly(index);
    };
    for (size_t i = 0; i < clips.size(); ++i) choice(i);
    if (clips.size() > 1) {
        if (ImGui::Selectable("all", onCount == clips.size())) timeline.ChooseAll();
        ImGui::Separator();
        ImGui::TextDisabled("blend");
        for (size_t i = 0; i < clips.size(); ++i) {
            ImGui::PushID(static_cast<int>(i));
            bool isOn = clips[i].isOn;
            float weight = clips[i].weight;
            if (ImGui::Checkbox("##on", &isOn)) timeline.SetOn(i, isOn);
            ImGui::SameLine();
            ImGui::SetNextItemWidth(90.0f);
            if (ImGui::SliderFloat(clips[i].name.c_str(), &weight, 0.0f, 1.0f, "%.2f",
                                   ImGuiSliderFlags_AlwaysClamp))
                timeline.SetWeight(i, weight);
            ImGui::PopID();
        }
    }
    ImGui::EndCombo();
}

}  // namespace

void TimelinePanel(Workspace& work) {
    Timeline& timeline = work.timeline;
    if (ImGui::Button(timeline.IsPlaying() ? "Pause" : "Play", {kButton, 0.0f})) timeline.Toggle();
    ImGui::SameLine();
    if (ImGui::Button("Stop", {kButton, 0.0f})) timeline.Stop();
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1.0f);
    float seconds = static_cast<float>(timeline.Seconds());
    const std::string format =
        timeline.IsAtRest() ? "rest pose" : Text("%.2f of {:.2f} s", timeline.Length());
    if (ImGui::SliderFloat("##time", &seconds, 0.0f, static_cast<float>(timeline.Length()), format.c_str(),
                           ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat))
        timeline.Seek(double{seconds});

    ImGui::Checkbox("loop", &timeline.isLooping);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(kSpeed);
    ImGui::DragFloat("##speed", &timeline.speed, 0.01f, kSpeedRange.min, kSpeedRange.max, "%.2f x speed",
                     ImGuiSliderFlags_AlwaysClamp);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1.0f);
    ClipChoice(timeline);
}

}  // namespace raygraph::editor
