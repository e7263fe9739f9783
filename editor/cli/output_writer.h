// Writing the outputs of a command, each on its own: one that cannot be written keeps no other from it.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

#include "editor/cli/exit_code.h"

namespace raygraph::cli {

class OutputWriter {
  public:
    // `say` is given each output that fails, and the line for it, which names it.
    using Say = std::function<void(const std::filesystem::path& file, std::string_view why)>;
    explicit OutputWriter(Say say) : m_say(std::move(say)) {}

    // `write` throws if it fails.
    void Add(const std::filesystem::path& file, std::function<void()> write);
    // Writes what was added since the last time, in that order, but devices and pipes after all files: one
    // whose reader does not come, or does not read, keeps no file from being written in time.
    void WriteAll();

    // In the order in which they were written.
    const std::vector<std::filesystem::path>& Written() const { return m_written; }
    bool HasWritten(const std::filesystem::path& file) const;
    // Whether its write has failed, and has left a part of it in the place of what was there (TornFile).
    bool IsTorn(const std::filesystem::path& file) const;
    // Done, or the status for the first output that failed.
    ExitCode Result() const { return m_result; }

  private:
    struct Output {
        std::filesystem::path file;
        std::function<void()> write;
    };

    Say m_say;
    std::vector<Output> m_outputs;
    std::vector<std::filesystem::path> m_written, m_torn;
    ExitCode m_result = ExitCode::Done;
};

}  // namespace raygraph::cli
