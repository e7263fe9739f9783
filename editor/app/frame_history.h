// Times of the last frames, and samples per second. Pure: the caller provides times.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "renderer/graph/renderer.h"

namespace raygraph::editor {

class FrameHistory {
  public:
    static constexpr size_t kLength = 240;  // frames that are remembered

    void Add(const FrameTiming& timing);
    size_t Count() const { return m_frames.size(); }
    // Milliseconds, oldest first, Count() of them.
    std::vector<float> Gpu() const;
    std::vector<float> Cpu() const;  // declaring, compiling, recording, submitting
    struct Pass {
        std::string name;       // passes of one name are one
        std::vector<float> ms;  // on the device; 0 where it was not executed
        float mean = 0.0f;
    };
    // The slowest pass first.
    std::vector<Pass> Passes() const;

  private:
    struct Timed {
        float cpuMs = 0.0f;
        std::vector<std::pair<size_t, float>> passes;  // index into m_names, milliseconds
    };
    std::deque<Timed> m_frames;
    std::vector<std::string> m_names;
};

// Samples a second over the last seconds.
class SampleRate {
  public:
    static constexpr double kSpan = 3.0;  // seconds

    // `samples`: of every pixel, with the part of the next one; fewer than before: accumulation restarted.
    void Note(double seconds, double samples);
    // None before a quarter of a second.
    std::optional<double> PerSecond() const;

  private:
    struct Point {
        double seconds, samples;
    };
    std::deque<Point> m_points;
};

// Seconds until the error, which falls with the square root of the number of samples, reaches `target`; 0:
// it has.
double SecondsLeft(double error, double target, double samples, double samplesPerSecond);

}  // namespace raygraph::editor
