// UnsavedDialog asks whether to save or discard unsaved edits. Main thread only.
#pragma once

#include <functional>
#include <string>

#include "editor/app/input.h"

namespace raygraph::editor {

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
