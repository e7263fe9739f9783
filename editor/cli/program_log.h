// The program's log: what the libraries and the commands have to say, by spdlog to stderr, to a file and to
// the editor.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "editor/cli/progress.h"

namespace raygraph::cli {

// What every command is told about its output.
struct OutputArguments {
    bool isQuiet = false;  // on stderr errors alone
    ProgressStyle progress = ProgressStyle::Auto;
    uint32_t verbosity = 0;         // -v: 1, information; -vv: 2, all
    std::filesystem::path logFile;  // "": none
};

// Threads: any, once it is made.
class ProgramLog {
  public:
    // Lines on `progress`'s stream come above its line. `levels` is RAYGRAPH_LOG, null: not set; the options
    // may ask for more. Error{BadInput} for bad levels, Error{Io} for a file that cannot be written.
    ProgramLog(const OutputArguments& arguments, const char* levels, Progress& progress);
    ~ProgramLog();
    ProgramLog(const ProgramLog&) = delete;
    ProgramLog& operator=(const ProgramLog&) = delete;

    // For what listens beside: everything from LogLevel::Info on, or from what was asked for below that.
    // Before ForLibraries; `receive` is called from any thread, one at a time, and outlives the log.
    void AddListener(Log::Callback receive);
    // What devices and loaders are given. Outlived by the log.
    Log ForLibraries();

    // Of the command itself.
    void Warn(std::string_view text);
    // Says an error, in the place of the line of progress, because what that shows has ended.
    void Fail(std::string_view text);
    // Throws Error{Vulkan} with the first validation message and their number, if there was any since it
    // threw the last time.
    void RequireValid();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace raygraph::cli
