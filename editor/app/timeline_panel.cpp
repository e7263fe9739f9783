// Draws the timeline below the picture: the clips, the time, and playback.
#include <imgui.h>

#include <string>

#include "base/text.h"
#include "editor/app/panels.h"

namespace raygraph::editor {

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
