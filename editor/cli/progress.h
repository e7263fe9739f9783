// Shows on stderr how far a command is: a line that a terminal redraws, lines of text, or JSON.
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

// Returns e.g. "  128/256 samples  1.23 Msamples/s  error 1.8 %  12 s left".
std::string FormatProgress(const ProgressState& state);
// Returns e.g. "  loading meshes  40 %".
std::string FormatLoading(std::string_view stage, float fraction);
// Returns e.g. "1.23 Msamples/s".
std::string FormatRate(double samplesPerSecond);

// Threads: any. It uses no escape sequences: blanks overwrite the line of a terminal, which works on any
// terminal and honors NO_COLOR.
//
// A run is what a command shows between two calls of Clear. Of each stage of loading, each step, and the
// samples of a run, the first state is always shown, and the last too where lines stay; between them, the
// style limits the rate.
class Progress {
  public:
    // `stream` must outlive the object. `isQuiet` shows nothing; it goes with Auto and None.
    Progress(std::FILE* stream, bool isQuiet, ProgressStyle style = ProgressStyle::Auto);
    ~Progress() { Clear(); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    // Returns whether progress is shown at all.
    bool IsOn() const { return m_style != ProgressStyle::None; }

    void ShowLoading(std::string_view stage, float fraction);
    // Shows work without a measure: "warming up". Spaces at the ends of `what` are ignored.
    void ShowStep(std::string_view what);
    // `picture` is e.g. "frame 2 of 10", or "" for the only one.
    void ShowSamples(std::string_view picture, const ProgressState& state);
    // Reports complete files to scripts; people read it on stdout.
    void ShowWritten(std::string_view picture, std::span<const std::filesystem::path> files);
    // Ends a run: clears the line of a terminal for other text.
    void Clear();
    // Prints `text`, which ends in a line break, even if progress is off. On a terminal, the line of progress
    // follows it.
    void PrintAboveProgress(std::string_view text);

  private:
    using Clock = std::chrono::steady_clock;

    // `textOf` formats the line in this style; `key` identifies what the states belong to.
    template <typename TextOf>
    void Show(std::string_view key, TextOf&& textOf);
    void ShowLastState();
    void Draw();       // draws m_line
    void ClearLine();  // clears the line from the terminal

    std::FILE* m_stream;
    const ProgressStyle m_style;  // Auto: stderr is a terminal
    mutable std::mutex m_mutex;   // guards all members below
    std::string m_line;           // Auto: pending line; "": none
    size_t m_shownWidth = 0;      // Auto: width of the drawn line
    std::string m_key;            // key that was shown last; "": none in this run
    std::string m_lastState;      // newest state that came too early to be shown; "": none
    Clock::time_point m_nextTime;
};

}  // namespace raygraph::cli
