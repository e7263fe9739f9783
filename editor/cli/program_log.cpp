#include "editor/cli/program_log.h"

#include <fmt/ranges.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <algorithm>
#include <atomic>
#include <map>
#include <utility>
#include <vector>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::cli {

namespace {

spdlog::level::level_enum ToSpdlog(LogLevel level) {
    switch (level) {
        case LogLevel::Debug:
            return spdlog::level::debug;
        case LogLevel::Info:
            return spdlog::level::info;
        case LogLevel::Warning:
            return spdlog::level::warn;
        case LogLevel::Error:
            return spdlog::level::err;
        case LogLevel::Off:
            break;
    }
    return spdlog::level::off;
}

// Returns our highest level that is not above spdlog's, which has more of them.
LogLevel FromSpdlog(spdlog::level::level_enum level) {
    LogLevel highest = LogLevel::Debug;
    for (int i = 0; i < static_cast<int>(LogLevel::Off); ++i)
        if (ToSpdlog(static_cast<LogLevel>(i)) <= level) highest = static_cast<LogLevel>(i);
    return highest;
}

LogMessage MessageOf(const spdlog::details::log_msg& message) {
    return {FromSpdlog(message.level),
            {message.logger_name.data(), message.logger_name.size()},
            {message.payload.data(), message.payload.size()}};
}

// Prints one line per message, above the progress line. Warnings and errors show no category, since they
// concern everybody.
class TerminalSink : public spdlog::sinks::base_sink<std::mutex> {
  public:
    TerminalSink(Progress& progress, LogLevels levels) : m_progress(progress), m_levels(std::move(levels)) {}

  protected:
    void sink_it_(const spdlog::details::log_msg& raw) override {
        const LogMessage message = MessageOf(raw);
        if (message.level < m_levels.Of(message.category)) return;
        if (message.level >= LogLevel::Warning)
            m_progress.PrintAboveProgress(Text("raygraph: {}: {}\n", Name(message.level), message.text));
        else
            m_progress.PrintAboveProgress(
                Text("raygraph: {}: [{}] {}\n", Name(message.level), message.category, message.text));
    }
    void flush_() override {}

  private:
    Progress& m_progress;
    LogLevels m_levels;
};

class ListenerSink : public spdlog::sinks::base_sink<std::mutex> {
  public:
    explicit ListenerSink(Log::Callback receive) : m_receive(std::move(receive)) {}

  protected:
    void sink_it_(const spdlog::details::log_msg& raw) override { m_receive(MessageOf(raw)); }
    void flush_() override {}

  private:
    Log::Callback m_receive;
};

LogLevels LevelsFor(const OutputArguments& arguments, const char* text) {
    LogLevels levels;
    if (text && *text) {
        try {
            levels = ParseLogLevels(text);
        } catch (const Error& error) {
            throw MakeError(error.Kind(), "RAYGRAPH_LOG: {}", error.what());
        }
    }
    if (arguments.verbosity == 0) return levels;
    return levels.AtLeast(arguments.verbosity == 1 ? LogLevel::Info : LogLevel::Debug);
}

// A command that had validation messages ends with the first of them, so the terminal shows them separately
// only if more output is asked for.
LogLevels LevelsForTerminal(const OutputArguments& arguments, LogLevels levels) {
    if (arguments.isQuiet) return {.general = LogLevel::Off, .byCategory = {}};
    if (levels.general >= LogLevel::Warning)
        levels.byCategory.try_emplace(std::string(log_category::kValidation), LogLevel::Off);
    return levels;
}

std::shared_ptr<spdlog::sinks::sink> OpenFile(const std::filesystem::path& path) {
    try {
        auto sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(path.string());
        sink->set_pattern("%Y-%m-%d %H:%M:%S.%e %-7l %-10n %v");
        return sink;
    } catch (const spdlog::spdlog_ex& failure) {
        throw MakeError(ErrorKind::Io, "--log: {}", failure.what());
    }
}

}  // namespace

struct ProgramLog::Impl {
    Impl(Progress& shownOn, LogLevels requested) : progress(shownOn), levels(std::move(requested)) {}

    spdlog::logger& LoggerOf(std::string_view category) {
        const auto known = loggers.find(category);
        return known == loggers.end() ? *loggers.find(kProgramCategory)->second : *known->second;
    }
    void AddSink(const std::shared_ptr<spdlog::sinks::sink>& sink) {
        for (const auto& [category, logger] : loggers) logger->sinks().push_back(sink);
    }
    // Lowers the levels for a sink that gets more than the terminal.
    void ListenFromInfo() {
        levels = levels.AtLeast(LogLevel::Info);
        for (const auto& [category, logger] : loggers) logger->set_level(ToSpdlog(levels.Of(category)));
    }
    void MakeLogger(std::string_view category) {
        auto logger = std::make_shared<spdlog::logger>(std::string(category));
        logger->set_level(ToSpdlog(levels.Of(category)));
        logger->flush_on(spdlog::level::debug);
        ReportFirstFailure(*logger);
        loggers.emplace(category, std::move(logger));
    }
    // Otherwise spdlog prints a line of its own to stderr at every failure, such as when the disk is full.
    void ReportFirstFailure(spdlog::logger& logger) {
        logger.set_error_handler([this](const std::string& what) {
            if (!hasFailed.exchange(true))
                progress.PrintAboveProgress(Text("raygraph: warning: the log is not complete: {}\n", what));
        });
    }

    Progress& progress;
    LogLevels levels;
    std::map<std::string, std::shared_ptr<spdlog::logger>, std::less<>> loggers;  // keyed by category
    std::shared_ptr<spdlog::logger> file;  // for messages that reach the terminal in another way
    std::atomic<bool> hasFailed{false};
    std::mutex mutex;
    std::vector<std::string> validation;  // since RequireValid threw
};

ProgramLog::ProgramLog(const OutputArguments& arguments, const char* levels, Progress& progress)
    : m_impl(std::make_unique<Impl>(progress, LevelsFor(arguments, levels))) {
    for (const std::string_view category : kLogCategories) m_impl->MakeLogger(category);
    m_impl->MakeLogger(kProgramCategory);
    m_impl->AddSink(std::make_shared<TerminalSink>(progress, LevelsForTerminal(arguments, m_impl->levels)));
    if (arguments.logFile.empty()) return;
    const std::shared_ptr<spdlog::sinks::sink> file = OpenFile(arguments.logFile);
    m_impl->AddSink(file);
    m_impl->ListenFromInfo();
    m_impl->file = std::make_shared<spdlog::logger>(std::string(kProgramCategory), file);
    m_impl->file->flush_on(spdlog::level::err);
    m_impl->ReportFirstFailure(*m_impl->file);
}

ProgramLog::~ProgramLog() = default;

void ProgramLog::AddListener(Log::Callback receive) {
    m_impl->AddSink(std::make_shared<ListenerSink>(std::move(receive)));
    m_impl->ListenFromInfo();
}

Log ProgramLog::ForLibraries() {
    const auto receive = [impl = m_impl.get()](const LogMessage& message) {
        std::string text(message.text);
        std::ranges::replace(text, '\n', ' ');
        impl->LoggerOf(message.category).log(ToSpdlog(message.level), text);
        if (message.category != log_category::kValidation) return;
        const std::scoped_lock lock(impl->mutex);
        impl->validation.push_back(std::move(text));
    };
    // Validation messages are counted whoever listens.
    return Log(receive, std::min(m_impl->levels.Lowest(), LogLevel::Warning));
}

void ProgramLog::Warn(std::string_view text) {
    m_impl->LoggerOf(kProgramCategory).warn(text);
}

void ProgramLog::Fail(std::string_view text) {
    m_impl->progress.Clear();
    m_impl->progress.PrintAboveProgress(Text("raygraph: {}\n", text));
    if (m_impl->file) m_impl->file->error(text);
}

void ProgramLog::RequireValid() {
    const std::scoped_lock lock(m_impl->mutex);
    const std::vector<std::string> messages = std::exchange(m_impl->validation, {});
    if (messages.empty()) return;
    const size_t others = messages.size() - 1;
    throw MakeError(ErrorKind::Vulkan, "validation: {}{}", messages.front(),
                    others > 0 ? Text(" (and {} more)", others) : "");
}

// --- Levels of messages ---

namespace {

LogLevel ParseLevel(std::string_view text) {
    std::vector<std::string_view> names;
    for (int i = 0; i <= static_cast<int>(LogLevel::Off); ++i) {
        const auto level = static_cast<LogLevel>(i);
        if (text == Name(level)) return level;
        names.emplace_back(Name(level));
    }
    throw MakeError(ErrorKind::BadInput, "{} is no level: {}", Quoted(text), fmt::join(names, ", "));
}

void RequireCategory(std::string_view text) {
    std::vector<std::string_view> known(kLogCategories.begin(), kLogCategories.end());
    known.push_back(kProgramCategory);
    if (std::ranges::find(known, text) == known.end())
        throw MakeError(ErrorKind::BadInput, "{} is no category: {}", Quoted(text), fmt::join(known, ", "));
}

}  // namespace

LogLevel LogLevels::Of(std::string_view category) const {
    const auto known = byCategory.find(category);
    return known == byCategory.end() ? general : known->second;
}

LogLevel LogLevels::Lowest() const {
    LogLevel lowest = general;
    for (const auto& [category, level] : byCategory) lowest = std::min(lowest, level);
    return lowest;
}

LogLevels LogLevels::AtLeast(LogLevel level) const {
    LogLevels levels = *this;
    levels.general = std::min(general, level);
    return levels;
}

LogLevels ParseLogLevels(std::string_view text) {
    LogLevels levels;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find(',', begin), text.size());
        const std::string_view entry = text.substr(begin, end - begin);
        begin = end + 1;
        const size_t equals = entry.find('=');
        if (equals == std::string_view::npos) {
            levels.general = ParseLevel(entry);
            continue;
        }
        const std::string_view category = entry.substr(0, equals);
        RequireCategory(category);
        levels.byCategory[std::string(category)] = ParseLevel(entry.substr(equals + 1));
    }
    return levels;
}

}  // namespace raygraph::cli
