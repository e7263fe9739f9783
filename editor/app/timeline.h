// Which of a scene's animations are shown, at what time, and how that goes on. Pure state: Document shows it.
//
// All clips that are on are at one time, which a render says as `--at` and `--clips`: a short one stays at
// its end until the longest has ended. Threads: exclusive access.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "editor/app/settings.h"
#include "renderer/scene/pose.h"

namespace raygraph::editor {

inline constexpr Range kSpeedRange{-4.0f, 4.0f};

class Timeline {
  public:
    Timeline() = default;  // of a scene without animations
    // At rest, with the scene's first animation on.
    explicit Timeline(const scene::SceneData& scene);

    struct Clip {
        std::string name;      // never empty
        double seconds = 0.0;  // its length
        bool isOn = false;
        float weight = 1.0f;  // of those that are on together
    };
    std::span<const Clip> Clips() const { return m_clips; }  // by animation
    bool IsEmpty() const { return m_clips.empty(); }
    // "walk", "walk 0.30, run", "all": those that are on.
    std::string ClipsLabel() const;

    // Turns on these and nothing else, with their weights. Their times do not count.
    void Choose(std::span<const scene::ClipState> clips);
    void ChooseOnly(size_t clip);  // and ChooseAll: with weight 1
    void ChooseAll();
    void SetOn(size_t clip, bool isOn);
    // 0 to 1.
    void SetWeight(size_t clip, float weight);

    // A scene without animations neither plays nor leaves its rest pose.
    bool IsPlaying() const { return m_isPlaying; }
    // Nothing is shown of any animation.
    bool IsAtRest() const { return m_isAtRest; }
    double Seconds() const { return m_seconds; }
    // The time of the last key of what is on.
    double Length() const;
    // From where it is; from the start if that is where it would end.
    void Play();
    void Pause() { m_isPlaying = false; }
    void Toggle() { m_isPlaying ? Pause() : Play(); }
    // Back to the rest pose and to the start.
    void Stop();
    // Shows that time, limited to the length. Goes on playing if it did.
    void Seek(double seconds);
    // Lets real time pass. Does nothing unless it plays. Without looping it ends at the last key, or
    // backwards at the start, and is paused there.
    void Advance(double realSeconds);

    bool isLooping = true;
    float speed = 1.0f;

    // What is shown, clips with a weight; empty at rest. Valid until the next change.
    std::span<const scene::ClipState> Shown() const { return m_shown; }

  private:
    void Refresh();

    std::vector<Clip> m_clips;
    std::vector<scene::ClipState> m_shown;
    double m_seconds = 0.0;
    bool m_isPlaying = false, m_isAtRest = true;
};

}  // namespace raygraph::editor
