#include "editor/app/timeline.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/text.h"

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

std::vector<scene::ClipState> Timeline::Chosen() const {
    std::vector<scene::ClipState> chosen;
    for (size_t i = 0; i < m_clips.size(); ++i)
        if (m_clips[i].isOn && m_clips[i].weight > 0.0f)
            chosen.push_back({static_cast<uint32_t>(i), m_seconds, m_clips[i].weight});
    return chosen;
}

void Timeline::Refresh() {
    m_seconds = std::clamp(m_seconds, 0.0, Length());
    m_shown.clear();
    if (!m_isAtRest) m_shown = Chosen();
}

}  // namespace raygraph::editor
