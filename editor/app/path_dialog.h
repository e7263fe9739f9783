// Asks for the path of a file.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace raygraph::editor {

class PathDialog {
  public:
    enum class For : unsigned char { Reading, Writing };
    // Opens the dialog from the next Draw until the user has answered. Draw passes the entered path to `use`.
    void Ask(std::string title, std::string hint, For purpose, const std::filesystem::path& suggestion,
             std::function<void(const std::filesystem::path&)> use);
    void Draw();

  private:
    std::string m_title, m_hint;
    For m_purpose = For::Reading;
    std::function<void(const std::filesystem::path&)> m_use;
    bool m_isAsked = false;  // Ask was called since the last Draw
    char m_path[1024] = {};
};

}  // namespace raygraph::editor
