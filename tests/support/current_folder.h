// Makes a folder the current one of the process for a test. Not while other threads use relative paths.
#pragma once

#include <filesystem>
#include <system_error>

namespace raygraph::test {

class CurrentFolder {
  public:
    explicit CurrentFolder(const std::filesystem::path& folder) { std::filesystem::current_path(folder); }
    ~CurrentFolder() {
        std::error_code ignored;
        std::filesystem::current_path(m_before, ignored);
    }
    CurrentFolder(const CurrentFolder&) = delete;
    CurrentFolder& operator=(const CurrentFolder&) = delete;

  private:
    std::filesystem::path m_before = std::filesystem::current_path();
};

}  // namespace raygraph::test
