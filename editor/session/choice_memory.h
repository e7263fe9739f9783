// What was measured on a device, and is remembered from one process to the next. For editor/session/ alone.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace raygraph::session {

// A text file: lines of a key, a tab and what is known of it. Threads: one at a time; processes may share a
// file, of which the last one to write keeps its choice.
class ChoiceMemory {
  public:
    // An empty path: nothing is remembered.
    explicit ChoiceMemory(std::filesystem::path file) : m_file(std::move(file)) {}

    // None where it is not known, and without a file.
    std::optional<std::string> Find(std::string_view key) const;
    // Neither text has a tab or an end of a line; those of a key become spaces. A file that cannot be written
    // is left alone: it is measured again next time.
    void Remember(std::string_view key, std::string_view known) const;

  private:
    std::filesystem::path m_file;
};

}  // namespace raygraph::session
