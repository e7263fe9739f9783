// ProgramLog sends the messages of the libraries and the commands through spdlog to stderr, to a file and to
// the editor.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "editor/cli/progress.h"

namespace raygraph::cli {

// Holds the output options that all commands share.
struct OutputArguments {
    bool isQuiet = false;  // only errors on stderr
    ProgressStyle progress = ProgressStyle::Auto;
    uint32_t verbosity = 0;         // 1 (-v): information; 2 (-vv): everything
    std::filesystem::path logFile;  // "": none
};

// Threads: any, after construction.
class ProgramLog {
  public:
    // Messages to `progress`'s stream are printed above its line. `levels` is RAYGRAPH_LOG, or null; the
    // options may lower the levels. Throws Error{BadInput} for malformed levels, Error{Io} if the file cannot
    // be written.
    ProgramLog(const OutputArguments& arguments, const char* levels, Progress& progress);
    ~ProgramLog();
    ProgramLog(const ProgramLog&) = delete;
    ProgramLog& operator=(const ProgramLog&) = delete;

    // Adds a listener for everything from LogLevel::Info on, or from a lower level that was asked for. Call
    // it before ForLibraries. `receive` is called from any thread, one call at a time, and outlives the log.
    void AddListener(Log::Callback receive);
    // Returns the log for devices and loaders, which must not outlive this object.
    Log ForLibraries();

    // Logs a warning of the command itself.
    void Warn(std::string_view text);
    // Prints an error in place of the line of progress, since the work has ended.
    void Fail(std::string_view text);
    // Throws Error{Vulkan} with the first validation message and their number if there was any since it threw
    // last.
    void RequireValid();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

// --- LogLevels: the minimal level of messages, overall and by category: RAYGRAPH_LOG and -v ---

// Is the category of the program's own messages, beside kLogCategories.
inline constexpr std::string_view kProgramCategory = "program";

struct LogLevels {
    LogLevel general = LogLevel::Warning;
    std::map<std::string, LogLevel, std::less<>> byCategory;  // exceptions from the overall level

    LogLevel Of(std::string_view category) const;
    // Returns the lowest level of any category.
    LogLevel Lowest() const;
    // Returns these levels with every category that was not named lowered to `level`, if it is higher.
    LogLevels AtLeast(LogLevel level) const;
};

// Parses "info", "shaders=debug", "warning,cache=off,shaders=debug". Throws Error{BadInput}.
LogLevels ParseLogLevels(std::string_view text);

}  // namespace raygraph::cli
