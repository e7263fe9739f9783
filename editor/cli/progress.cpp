#include "editor/cli/progress.h"

#include <array>
#include <cmath>

#include "base/os/process.h"

namespace raygraph::cli {

namespace {

constexpr auto kRedrawInterval = std::chrono::milliseconds(200);

template <typename... Values>
std::string Printed(const char* format, Values... values) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
}

}  // namespace

std::string FormatProgress(const ProgressState& state) {
    std::string line = "  ";
    line += std::to_string(state.samplesDone);
    if (state.samplesWanted) {
        line += '/';
        line += std::to_string(*state.samplesWanted);
    }
    line += state.samplesDone == 1 && !state.samplesWanted ? " sample" : " samples";
    if (state.samplesPerSecond > 0.0) {
        line += "  ";
        line += FormatRate(state.samplesPerSecond);
    }
    if (state.relativeError) line += Printed("  error %.2g %%", *state.relativeError * 100.0);
    if (state.secondsLeft) {
        line += "  ";
        line += FormatDuration(*state.secondsLeft);
        line += " left";
    }
    return line;
}

std::string FormatLoading(std::string_view stage, float fraction) {
    std::string line = "  loading ";
    line += stage;
    return line + Printed("  %.0f %%", 100.0 * static_cast<double>(fraction));
}

std::string FormatRate(double samplesPerSecond) {
    return Printed("%.3g Msamples/s", samplesPerSecond * 1e-6);
}

std::string FormatDuration(double seconds) {
    if (seconds < 0.9995) return Printed("%.0f ms", seconds * 1e3);
    if (seconds < 9.95) return Printed("%.1f s", seconds);
    const auto whole = static_cast<long long>(std::llround(seconds));
    if (whole < 60) return Printed("%lld s", whole);
    if (whole < 3600) return Printed("%lld min %lld s", whole / 60, whole % 60);
    return Printed("%lld h %lld min", whole / 3600, whole % 3600 / 60);
}

Progress::Progress(std::FILE* stream, bool isQuiet)
    : m_stream(stream), m_isOn(!isQuiet && os::IsTerminal(stream)) {}

bool Progress::IsDue() const {
    return m_isOn && std::chrono::steady_clock::now() >= m_nextDraw;
}

void Progress::Show(std::string_view line) {
    if (!m_isOn) return;
    m_nextDraw = std::chrono::steady_clock::now() + kRedrawInterval;
    // A line as wide as the terminal would wrap
    line = line.substr(0, os::TerminalWidth(m_stream) - 1);
    std::string text = "\r";
    text += line;
    if (line.size() < m_shownWidth) text.append(m_shownWidth - line.size(), ' ');
    std::fputs(text.c_str(), m_stream);
    std::fflush(m_stream);
    m_shownWidth = line.size();
}

void Progress::Clear() {
    if (!m_isOn || m_shownWidth == 0) return;
    std::fprintf(m_stream, "\r%*s\r", static_cast<int>(m_shownWidth), "");
    std::fflush(m_stream);
    m_shownWidth = 0;
}

}  // namespace raygraph::cli
