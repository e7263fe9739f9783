// Dialogs: one asks for the path of a file, one whether to save or discard unsaved edits. Main thread only.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "editor/app/input.h"

namespace raygraph::editor {

// Asks for the path of a file.
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
    bool m_isRequested = false;  // Ask was called since the last Draw
    char m_path[1024] = {};
};

// Asks whether to save or discard unsaved edits, before an action that would lose them.
class UnsavedDialog {
  public:
    enum class Answer : unsigned char { Save, Discard, Cancel };
    // Opens the question from the next Draw until the user has answered by a button or by S, D or Escape; it
    // replaces an open question. Draw passes the answer to `use`. `question` names the file that would be
    // written.
    void Ask(std::string question, std::function<void(Answer)> use);
    bool IsPrompting() const { return static_cast<bool>(m_use); }
    void Draw(const FrameInput& input);

  private:
    std::string m_question;
    std::function<void(Answer)> m_use;
    bool m_isNew = false;  // Ask was called since the last Draw
};

}  // namespace raygraph::editor
