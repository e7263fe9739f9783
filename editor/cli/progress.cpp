#include "editor/cli/progress.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/os.h"
#include "base/printable.h"
#include "base/text.h"

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;
using Interval = std::chrono::steady_clock::duration;

Interval IntervalOf(ProgressStyle style) {
    switch (style) {
        case ProgressStyle::Auto:
            return std::chrono::milliseconds(200);
        case ProgressStyle::Plain:
            return std::chrono::seconds(10);
        case ProgressStyle::Json:
        case ProgressStyle::None:
            break;
    }
    return std::chrono::seconds(1);
}

ProgressStyle StyleOn(std::FILE* stream, bool isQuiet, ProgressStyle style) {
    if (isQuiet || (style == ProgressStyle::Auto && !os::IsTerminal(stream))) return ProgressStyle::None;
    return style;
}

std::string_view Trimmed(std::string_view text) {
    const size_t begin = text.find_first_not_of(' ');
    if (begin == text.npos) return {};
    return text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
}

// Two spaces separate the columns of a terminal's line; in a log, commas are easier to read.
std::string WithCommas(std::string_view columns) {
    std::string text(Trimmed(columns));
    for (size_t at = text.find("  "); at != text.npos; at = text.find("  ", at + 1))
        text.replace(at, 2, ", ");
    return text;
}

Json SamplesJson(std::string_view picture, const ProgressState& state) {
    const auto orNull = [](const auto& value) { return value ? Json(*value) : Json(); };
    Json json{{"event", state.samplesRestored ? "restoring" : "progress"}};
    if (!picture.empty()) json["picture"] = picture;
    if (state.samplesRestored) {
        json["samples"] = *state.samplesRestored;
        json["samples_wanted"] = state.samplesDone;
        return json;
    }
    json["samples"] = state.samplesDone;
    json["samples_wanted"] = orNull(state.samplesWanted);
    json["samples_per_second"] = state.samplesPerSecond > 0.0 ? Json(state.samplesPerSecond) : Json();
    json["relative_error"] = orNull(state.relativeError);
    json["seconds_left"] = orNull(state.secondsLeft);
    return json;
}

// Names may come from files: bytes that are not valid UTF-8 are replaced.
std::string LineOf(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string FormatProgress(const ProgressState& state) {
    if (state.samplesRestored)
        return Text("  restoring albedo and normals  {}/{}", *state.samplesRestored,
                    Counted(state.samplesDone, "sample"));
    std::string line = state.samplesWanted ? Text("  {}/", state.samplesDone) : "  ";
    line += Counted(state.samplesWanted.value_or(state.samplesDone), "sample");
    if (state.samplesPerSecond > 0.0) line += "  " + FormatRate(state.samplesPerSecond);
    if (state.relativeError) line += Text("  error {:.2g} %", *state.relativeError * 100.0);
    if (state.secondsLeft && *state.secondsLeft > 0.0)
        line += Text("  {} left", DurationText(*state.secondsLeft));
    return line;
}

std::string FormatLoading(std::string_view stage, float fraction) {
    return Text("  loading {}  {:.0f} %", stage, 100.0f * fraction);
}

std::string FormatRate(double samplesPerSecond) {
    return Text("{:.3g} Msamples/s", samplesPerSecond * 1e-6);
}

Progress::Progress(std::FILE* stream, bool isQuiet, ProgressStyle style)
    : m_stream(stream), m_style(StyleOn(stream, isQuiet, style)) {}

template <typename TextOf>
void Progress::Show(std::string_view key, TextOf&& textOf) {
    if (!IsOn()) return;
    const std::scoped_lock lock(m_mutex);
    const Clock::time_point now = Clock::now();
    const bool isDue = key != m_key || now >= m_nextTime;
    if (m_style == ProgressStyle::Auto) {
        if (!isDue) return;
        m_line = textOf(m_style);
        Draw();
    } else {
        std::string line = textOf(m_style);
        if (m_style == ProgressStyle::Plain) line = "raygraph: " + WithCommas(line);
        line += '\n';
        if (!isDue) {
            m_lastState = std::move(line);
            return;
        }
        if (key != m_key) ShowLastState();
        m_lastState.clear();
        std::fputs(line.c_str(), m_stream);
    }
    m_key = key;
    m_nextTime = now + IntervalOf(m_style);
    std::fflush(m_stream);
}

void Progress::ShowLoading(std::string_view stage, float fraction) {
    Show(Text("loading {}", stage), [&](ProgressStyle style) {
        if (style != ProgressStyle::Json) return FormatLoading(stage, fraction);
        // Keep only the significant digits of a float
        return LineOf(
            {{"event", "loading"}, {"stage", stage}, {"fraction", std::round(fraction * 1e3) / 1e3}});
    });
}

void Progress::ShowStep(std::string_view what) {
    what = Trimmed(what);
    Show(Text("step {}", what), [&](ProgressStyle style) {
        if (style != ProgressStyle::Json) return Text("  {}", what);
        return LineOf({{"event", "step"}, {"step", what}});
    });
}

void Progress::ShowSamples(std::string_view picture, const ProgressState& state) {
    picture = Trimmed(picture);
    const char* what = state.samplesRestored ? "restoring" : "samples";
    Show(Text("{} {}", what, picture), [&](ProgressStyle style) {
        if (style == ProgressStyle::Json) return LineOf(SamplesJson(picture, state));
        return picture.empty() ? FormatProgress(state) : Text("  {}{}", picture, FormatProgress(state));
    });
}

void Progress::ShowWritten(std::string_view picture, std::span<const std::filesystem::path> files) {
    if (m_style != ProgressStyle::Json) return;
    picture = Trimmed(picture);
    Json json{{"event", "written"}};
    if (!picture.empty()) json["picture"] = picture;
    json["files"] = Json::array();
    for (const std::filesystem::path& file : files) json["files"].push_back(file.string());
    PrintAboveProgress(LineOf(json) + "\n");
}

void Progress::Clear() {
    const std::scoped_lock lock(m_mutex);
    ShowLastState();
    ClearLine();
    std::fflush(m_stream);
    m_line.clear();
    m_key.clear();
}

void Progress::PrintAboveProgress(std::string_view text) {
    const std::scoped_lock lock(m_mutex);
    ClearLine();
    std::fwrite(text.data(), 1, text.size(), m_stream);
    if (!m_line.empty()) Draw();
    std::fflush(m_stream);
}

void Progress::ShowLastState() {
    std::fputs(m_lastState.c_str(), m_stream);
    m_lastState.clear();
}

void Progress::Draw() {
    // A line of the terminal's full width would wrap
    const std::string_view line = std::string_view(m_line).substr(0, os::TerminalWidth(m_stream) - 1);
    std::string text = "\r";
    text += line;
    if (line.size() < m_shownWidth) text.append(m_shownWidth - line.size(), ' ');
    std::fputs(text.c_str(), m_stream);
    m_shownWidth = line.size();
}

void Progress::ClearLine() {
    if (m_shownWidth == 0) return;
    std::fprintf(m_stream, "\r%*s\r", static_cast<int>(m_shownWidth), "");
    m_shownWidth = 0;
}

}  // namespace raygraph::cli
