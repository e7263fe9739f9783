// The one line on a terminal that says how a render is getting on.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <string>
#include <string_view>

#include "editor/session/run.h"

namespace raygraph::cli {

using session::ProgressState;

// "  128/256 samples  1.23 Msamples/s  error 1.8 %  12 s left"
std::string FormatProgress(const ProgressState& state);
// "  loading meshes  40 %"
std::string FormatLoading(std::string_view stage, float fraction);
// "1.23 Msamples/s"
std::string FormatRate(double samplesPerSecond);

// Redraws one line of a terminal; silent when it is off. Threads: any. No escape sequences: the line is
// overwritten by blanks, so any terminal and NO_COLOR are served.
class Progress {
  public:
    // `stream` outlives the object. On only if `stream` is a terminal and `isQuiet` is false.
    Progress(std::FILE* stream, bool isQuiet);
    ~Progress() { Clear(); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    bool IsOn() const { return m_isOn; }
    // True when a redraw is due: five times a second at most.
    bool IsDue() const;
    void Show(std::string_view line);
    // Leaves the line empty for other text.
    void Clear();
    // Writes `text`, which ends in a line break, also when it is off. The line is below it then.
    void PrintAbove(std::string_view text);

  private:
    void Draw();  // m_line
    void Lift();  // the line from the terminal

    std::FILE* m_stream;
    const bool m_isOn;
    mutable std::mutex m_mutex;  // of all that follows
    std::string m_line;          // to be shown; "": none
    size_t m_shownWidth = 0;     // of what is on the terminal
    std::chrono::steady_clock::time_point m_nextDraw;
};

}  // namespace raygraph::cli
