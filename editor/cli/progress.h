// How a command says on stderr how it gets on: a line that a terminal redraws, lines of text, or JSON.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <span>
#include <string>
#include <string_view>

#include "editor/session/run.h"
#include "shaders/shared/choice.h"

namespace raygraph::cli {

using session::ProgressState;

//   Auto:  redrawn in place; nothing where stderr is no terminal
//   Plain: lines that stay, one every ten seconds
//   Json:  an object a line, one a second; docs/cli.md
#define RAYGRAPH_PROGRESS_STYLES(X, Of)                           \
    X(Of, Auto, 0, "auto", "a redrawn line, on a terminal alone") \
    X(Of, Plain, 1, "plain", "lines of text, for log files")      \
    X(Of, Json, 2, "json", "JSON Lines, for scripts")             \
    X(Of, None, 3, "none", "nothing")
RAYGRAPH_CHOICE(ProgressStyle, RAYGRAPH_PROGRESS_STYLES)

// "  128/256 samples  1.23 Msamples/s  error 1.8 %  12 s left"
std::string FormatProgress(const ProgressState& state);
// "  loading meshes  40 %"
std::string FormatLoading(std::string_view stage, float fraction);
// "1.23 Msamples/s"
std::string FormatRate(double samplesPerSecond);

// Threads: any. No escape sequences: the line of a terminal is overwritten by blanks, so any terminal and
// NO_COLOR are served.
//
// What a command shows between two calls of Clear is a run. Of a stage of loading, a step, and the samples of
// a run, the first state is always shown, and the last too where lines stay; of those between, as many as the
// style allows.
class Progress {
  public:
    // `stream` outlives the object. Nothing is shown if `isQuiet`, which goes with Auto and None.
    Progress(std::FILE* stream, bool isQuiet, ProgressStyle style = ProgressStyle::Auto);
    ~Progress() { Clear(); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    // Whether what is told here is shown to anybody.
    bool IsOn() const { return m_style != ProgressStyle::None; }

    void ShowLoading(std::string_view stage, float fraction);
    // Something that takes a while and has no measure: "warming up". Spaces at its ends do not count.
    void ShowStep(std::string_view what);
    // `picture`: "frame 2 of 10", or "" for the only one.
    void ShowSamples(std::string_view picture, const ProgressState& state);
    // A script is told which files are complete; people read it on stdout.
    void ShowWritten(std::string_view picture, std::span<const std::filesystem::path> files);
    // Ends a run: leaves the line of a terminal empty for other text.
    void Clear();
    // Writes `text`, which ends in a line break, also when it is off. A terminal's line is below it then.
    void PrintAbove(std::string_view text);

  private:
    using Clock = std::chrono::steady_clock;

    // `textOf` makes the line in this style; `key` is the same for all states of one thing.
    template <typename TextOf>
    void Show(std::string_view key, TextOf&& textOf);
    void ShowLastState();
    void Draw();  // m_line
    void Lift();  // the line from the terminal

    std::FILE* m_stream;
    const ProgressStyle m_style;  // Auto: on a terminal
    mutable std::mutex m_mutex;   // of all that follows
    std::string m_line;           // Auto: to be shown; "": none
    size_t m_shownWidth = 0;      // Auto: of what is on the terminal
    std::string m_key;            // of what was shown last; "": nothing in this run
    std::string m_lastState;      // its newest, where that was too early to be shown; "": it was shown
    Clock::time_point m_nextTime;
};

}  // namespace raygraph::cli
