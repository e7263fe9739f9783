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

    // Calls `write`, which throws if it fails. Returns whether it did not.
    bool Write(const std::filesystem::path& file, const std::function<void()>& write);

    // In the order in which they were written.
    const std::vector<std::filesystem::path>& Written() const { return m_written; }
    bool HasWritten(const std::filesystem::path& file) const;
    // Done, or the status for the first output that failed.
    ExitCode Result() const { return m_result; }

  private:
    Say m_say;
    std::vector<std::filesystem::path> m_written;
    ExitCode m_result = ExitCode::Done;
};

}  // namespace raygraph::cli
