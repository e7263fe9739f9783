// Computes the numbers and texts of the statistics panel: rows of memory, times of the last frames, samples
// per second. Threads: pure functions; objects: one at a time. The caller provides the times.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "editor/viewport/real_time_errors.h"
#include "renderer/graph/renderer.h"
#include "rhi/device.h"

namespace raygraph::editor {

struct MemoryRow {
    std::string name, value;
};

// Returns rows for Raygraph's memory, for the part of it that was placed in host memory, and for the
// process's use of each heap's budget.
std::vector<MemoryRow> MemoryRows(const rhi::MemoryStatistics& memory,
                                  std::span<const rhi::MemoryHeap> heaps);

// FrameHistory keeps the times of the last frames.
class FrameHistory {
  public:
    static constexpr size_t kLength = 240;  // frames

    void Add(const FrameTiming& timing);
    size_t Count() const { return m_frames.size(); }
    // Returns milliseconds of each frame, oldest first; Count() values.
    std::vector<float> Gpu() const;
    std::vector<float> Cpu() const;  // time for declaring, compiling, recording and submitting
    struct Pass {
        std::string name;       // passes of one name are summed
        std::vector<float> ms;  // device time of each frame; 0: not executed
        float mean = 0.0f;
    };
    // Returns the passes, the slowest first.
    std::vector<Pass> Passes() const;

  private:
    struct Timed {
        float cpuMs = 0.0f;
        std::vector<std::pair<size_t, float>> passes;  // index into m_names, milliseconds
    };
    std::deque<Timed> m_frames;
    std::vector<std::string> m_names;
};

// Measures the samples per second over the last kSpan seconds.
class SampleRate {
  public:
    static constexpr double kSpan = 3.0;  // in seconds

    // `samples` counts samples per pixel, with the fraction of the next one. A smaller number than before
    // means that accumulation was restarted.
    void Add(double seconds, double samples);
    // Returns nothing before a quarter of a second has been measured.
    std::optional<double> PerSecond() const;

  private:
    struct Point {
        double seconds, samples;
    };
    std::deque<Point> m_points;
};

// RealTimeErrorHistory keeps the errors of the real-time view that were measured last.
class RealTimeErrorHistory {
  public:
    static constexpr size_t kLength = 240;

    void Add(const viewport::RealTimeErrors& errors);
    bool IsEmpty() const { return m_errors.empty(); }
    struct Curve {
        std::string text;                          // the name with the newest value
        std::vector<std::optional<float>> values;  // oldest first; none: not known then
    };
    // Returns a curve for each error, of as many values. The texts say of how many samples the reference was.
    std::vector<Curve> Curves() const;

  private:
    std::deque<viewport::RealTimeErrors> m_errors;
};

// Returns where a value lies on a logarithmic axis, 0 to 1 from `from` to `to`; values beyond are put on its
// ends.
float OnLogAxis(float value, float from, float to);

// Returns the seconds until the error, which falls with the square root of the number of samples, reaches
// `target`; 0 if it has.
double SecondsLeft(double error, double target, double samples, double samplesPerSecond);

}  // namespace raygraph::editor
