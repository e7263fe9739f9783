// OutputWriter writes the outputs of a command independently: a failure of one does not prevent the others.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

#include "editor/cli/exit_code.h"

namespace raygraph::cli {

class OutputWriter {
  public:
    // Is called for each output that fails, with a line that names the output.
    using Say = std::function<void(const std::filesystem::path& file, std::string_view why)>;
    explicit OutputWriter(Say say) : m_say(std::move(say)) {}

    // `write` throws if it fails.
    void Add(const std::filesystem::path& file, std::function<void()> write);
    // Writes what was added since the last call, in that order, but devices and pipes after all files: one
    // whose reader is missing or slow delays no file.
    void WriteAll();

    // Returns the files that were written, in order.
    const std::vector<std::filesystem::path>& Written() const { return m_written; }
    bool HasWritten(const std::filesystem::path& file) const;
    // Returns whether writing has failed and has left an incomplete file in place of the old one
    // (IncompleteFile).
    bool IsTorn(const std::filesystem::path& file) const;
    // Returns Done, or the status of the first output that failed.
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
