#include "editor/cli/output_writer.h"

#include <algorithm>

#include "editor/cli/run_command.h"

namespace raygraph::cli {

bool OutputWriter::Write(const std::filesystem::path& file, const std::function<void()>& write) {
    const ExitCode code = Guarded([&](const char* why) { m_say(file, why); },
                                  [&] {
                                      write();
                                      return ExitCode::Done;
                                  });
    if (m_result == ExitCode::Done) m_result = code;
    if (code == ExitCode::Done) m_written.push_back(file);
    return code == ExitCode::Done;
}

bool OutputWriter::HasWritten(const std::filesystem::path& file) const {
    return std::ranges::find(m_written, file) != m_written.end();
}

}  // namespace raygraph::cli
