// Timeline holds which of a scene's animations are shown, at what time, and plays them. It is pure state:
// Document shows it.
//
// All clips that are on share one time, which a render takes as `--at` and `--clips`; a short clip holds its
// last pose until the longest has ended. Threads: exclusive access.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "editor/app/settings.h"
#include "renderer/scene/animation/pose.h"

namespace raygraph::editor {

inline constexpr Range kSpeedRange{-4.0f, 4.0f};

class Timeline {
  public:
    Timeline() = default;  // for a scene without animations
    // Starts at rest, with the scene's first animation on.
    explicit Timeline(const scene::SceneData& scene);

    struct Clip {
        std::string name;      // never empty
        double seconds = 0.0;  // length
        bool isOn = false;
        float weight = 1.0f;  // relative to the other clips that are on
    };
    std::span<const Clip> Clips() const { return m_clips; }  // indexed by animation
    bool IsEmpty() const { return m_clips.empty(); }
    // Returns the clips that are on: "walk", "walk 0.30, run", "all".
    std::string ClipsLabel() const;

    // Returns them, with their weights, at the present time.
    std::vector<scene::ClipState> Chosen() const;

    // Turns on exactly these clips, with their weights. Their times are ignored.
    void Choose(std::span<const scene::ClipState> clips);
    void ChooseOnly(size_t clip);  // like ChooseAll, with weight 1
    void ChooseAll();
    void SetOn(size_t clip, bool isOn);
    // `weight` is from 0 to 1.
    void SetWeight(size_t clip, float weight);

    // Returns whether time advances; never without animations, nor in the rest pose.
    bool IsPlaying() const { return m_isPlaying; }
    // Returns whether the rest pose is shown.
    bool IsAtRest() const { return m_isAtRest; }
    double Seconds() const { return m_seconds; }
    // Returns the time of the last key of the clips that are on, in seconds.
    double Length() const;
    // Plays from the current time, or from the start if playback would end there.
    void Play();
    void Pause() { m_isPlaying = false; }
    void Toggle() { m_isPlaying ? Pause() : Play(); }
    // Returns to the rest pose and to the start.
    void Stop();
    // Shows the pose at a time, clamped to the length. Playback continues.
    void Seek(double seconds);
    // Advances by real time while it plays. Without looping, playback pauses at the last key, or backwards at
    // the start.
    void Advance(double realSeconds);

    bool isLooping = true;
    float speed = 1.0f;

    // Returns the clips that are shown, with their weights; empty at rest. Valid until the next change.
    std::span<const scene::ClipState> Shown() const { return m_shown; }

  private:
    void Refresh();

    std::vector<Clip> m_clips;
    std::vector<scene::ClipState> m_shown;
    double m_seconds = 0.0;
    bool m_isPlaying = false, m_isAtRest = true;
};

}  // namespace raygraph::editor
