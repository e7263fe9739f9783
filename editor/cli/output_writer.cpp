#include "editor/cli/output_writer.h"

#include <algorithm>
#include <utility>

#include "base/atomic_file.h"
#include "editor/cli/run_command.h"

namespace raygraph::cli {

void OutputWriter::Add(const std::filesystem::path& file, std::function<void()> write) {
    m_outputs.push_back({file, std::move(write)});
}

void OutputWriter::WriteAll() {
    std::ranges::stable_partition(m_outputs,
                                  [](const Output& output) { return !AtomicFile::IsStream(output.file); });
    for (const auto& [file, write] : std::exchange(m_outputs, {})) {
        const ExitCode code = Guarded([&](const char* why) { m_say(file, why); },
                                      [&] {
                                          try {
                                              write();
                                          } catch (const IncompleteFile&) {
                                              m_torn.push_back(file);
                                              throw;
                                          }
                                          return ExitCode::Done;
                                      });
        if (m_result == ExitCode::Done) m_result = code;
        if (code == ExitCode::Done) m_written.push_back(file);
    }
}

bool OutputWriter::HasWritten(const std::filesystem::path& file) const {
    return std::ranges::find(m_written, file) != m_written.end();
}

bool OutputWriter::IsTorn(const std::filesystem::path& file) const {
    return std::ranges::find(m_torn, file) != m_torn.end();
}

}  // namespace raygraph::cli
