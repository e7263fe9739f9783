#include "editor/app/timeline.h"

#include <imgui.h>
#include <algorithm>
#include <cmath>
#include <string>

#include "base/text.h"
#include "editor/app/panels.h"

namespace raygraph::editor {

Timeline::Timeline(const scene::SceneData& scene) {
    for (const scene::Animation& animation : scene.animations)
        m_clips.push_back(
            {.name = animation.name.empty() ? Text("animation {}", m_clips.size()) : animation.name,
             .seconds = double{animation.duration}});
    if (!m_clips.empty()) m_clips.front().isOn = true;
}

std::string Timeline::ClipsLabel() const {
    const auto count = std::ranges::count_if(m_clips, &Clip::isOn);
    if (count == 0) return "none";
    const bool isWhole = std::ranges::all_of(m_clips, [](const Clip& clip) { return clip.weight == 1.0f; });
    if (count > 1 && static_cast<size_t>(count) == m_clips.size() && isWhole) return "all";
    std::string label;
    for (const Clip& clip : m_clips)
        if (clip.isOn)
            label += Text("{}{}{}", label.empty() ? "" : ", ", clip.name,
                          clip.weight == 1.0f ? "" : Text(" {:.2f}", clip.weight));
    return label;
}

void Timeline::Choose(std::span<const scene::ClipState> clips) {
    for (Clip& clip : m_clips) clip = {.name = std::move(clip.name), .seconds = clip.seconds};
    for (const scene::ClipState& chosen : clips) {
        Clip& clip = m_clips.at(chosen.animation);
        clip.isOn = true;
        clip.weight = chosen.weight;
    }
    Refresh();
}

void Timeline::ChooseOnly(size_t clip) {
    for (size_t i = 0; i < m_clips.size(); ++i) m_clips[i].isOn = i == clip;
    m_clips.at(clip).weight = 1.0f;
    Refresh();
}

void Timeline::ChooseAll() {
    for (Clip& clip : m_clips) {
        clip.isOn = true;
        clip.weight = 1.0f;
    }
    Refresh();
}

void Timeline::SetOn(size_t clip, bool isOn) {
    m_clips.at(clip).isOn = isOn;
    Refresh();
}

void Timeline::SetWeight(size_t clip, float weight) {
    m_clips.at(clip).weight = std::clamp(weight, 0.0f, 1.0f);
    Refresh();
}

double Timeline::Length() const {
    double length = 0.0;
    for (const Clip& clip : m_clips)
        if (clip.isOn) length = std::max(length, clip.seconds);
    return length;
}

void Timeline::Play() {
    if (m_clips.empty()) return;
    if (!isLooping && (speed < 0.0f ? m_seconds <= 0.0 : m_seconds >= Length()))
        m_seconds = speed < 0.0f ? Length() : 0.0;
    m_isPlaying = true;
    m_isAtRest = false;
    Refresh();
}

void Timeline::Stop() {
    m_isPlaying = false;
    m_isAtRest = true;
    m_seconds = 0.0;
    Refresh();
}

void Timeline::Seek(double seconds) {
    if (m_clips.empty() || !std::isfinite(seconds)) return;
    m_seconds = seconds;
    m_isAtRest = false;
    Refresh();
}

void Timeline::Advance(double realSeconds) {
    if (!m_isPlaying) return;
    const double length = Length(), now = m_seconds + double{speed} * realSeconds;
    if (isLooping) {
        m_seconds = length > 0.0 ? std::fmod(now, length) : 0.0;
        if (m_seconds < 0.0) m_seconds += length;
    } else {
        m_seconds = now;
        m_isPlaying = speed < 0.0f ? now > 0.0 : now < length;
    }
    Refresh();
}

void Timeline::Refresh() {
    m_seconds = std::clamp(m_seconds, 0.0, Length());
    m_shown.clear();
    for (size_t i = 0; i < m_clips.size() && !m_isAtRest; ++i)
        if (m_clips[i].isOn && m_clips[i].weight > 0.0f)
            m_shown.push_back({static_cast<uint32_t>(i), m_seconds, m_clips[i].weight});
}

// --- Drawing the timeline below the picture: the clips, the time, and playback ---

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
