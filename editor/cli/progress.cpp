#include "editor/cli/progress.h"

#include "base/os/process.h"
#include "base/text.h"

namespace raygraph::cli {

namespace {

constexpr auto kRedrawInterval = std::chrono::milliseconds(200);

}  // namespace

std::string FormatProgress(const ProgressState& state) {
    if (state.samplesRestored)
        return Text("  restoring albedo and normals  {}/{} samples", *state.samplesRestored,
                    state.samplesDone);
    std::string line = Text("  {}", state.samplesDone);
    if (state.samplesWanted) line += Text("/{}", *state.samplesWanted);
    line += state.samplesDone == 1 && !state.samplesWanted ? " sample" : " samples";
    if (state.samplesPerSecond > 0.0) line += "  " + FormatRate(state.samplesPerSecond);
    if (state.relativeError) line += Text("  error {:.2g} %", *state.relativeError * 100.0);
    if (state.secondsLeft) line += Text("  {} left", DurationText(*state.secondsLeft));
    return line;
}

std::string FormatLoading(std::string_view stage, float fraction) {
    return Text("  loading {}  {:.0f} %", stage, 100.0f * fraction);
}

std::string FormatRate(double samplesPerSecond) {
    return Text("{:.3g} Msamples/s", samplesPerSecond * 1e-6);
}

Progress::Progress(std::FILE* stream, bool isQuiet)
    : m_stream(stream), m_isOn(!isQuiet && os::IsTerminal(stream)) {}

bool Progress::IsDue() const {
    if (!m_isOn) return false;
    const std::scoped_lock lock(m_mutex);
    return std::chrono::steady_clock::now() >= m_nextDraw;
}

void Progress::Show(std::string_view line) {
    if (!m_isOn) return;
    const std::scoped_lock lock(m_mutex);
    m_nextDraw = std::chrono::steady_clock::now() + kRedrawInterval;
    m_line = line;
    Draw();
    std::fflush(m_stream);
}

void Progress::Clear() {
    const std::scoped_lock lock(m_mutex);
    Lift();
    std::fflush(m_stream);
    m_line.clear();
}

void Progress::PrintAbove(std::string_view text) {
    const std::scoped_lock lock(m_mutex);
    Lift();
    std::fwrite(text.data(), 1, text.size(), m_stream);
    if (!m_line.empty()) Draw();
    std::fflush(m_stream);
}

void Progress::Draw() {
    // A line as wide as the terminal would wrap
    const std::string_view line = std::string_view(m_line).substr(0, os::TerminalWidth(m_stream) - 1);
    std::string text = "\r";
    text += line;
    if (line.size() < m_shownWidth) text.append(m_shownWidth - line.size(), ' ');
    std::fputs(text.c_str(), m_stream);
    m_shownWidth = line.size();
}

void Progress::Lift() {
    if (m_shownWidth == 0) return;
    std::fprintf(m_stream, "\r%*s\r", static_cast<int>(m_shownWidth), "");
    m_shownWidth = 0;
}

}  // namespace raygraph::cli
