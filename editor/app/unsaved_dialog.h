// Asks what becomes of edits that are not saved, before something that would lose them.
#pragma once

#include <functional>
#include <string>

#include "editor/app/input.h"

namespace raygraph::editor {

class UnsavedDialog {
  public:
    enum class Answer : unsigned char { Save, Discard, Cancel };
    // From the next Draw on, until the user has answered by a button or S, D or Escape; a question that is
    // open is replaced. `use` is called by Draw with the answer. `file` is what would be written.
    void Ask(std::string file, std::function<void(Answer)> use);
    bool IsAsking() const { return static_cast<bool>(m_use); }
    void Draw(const FrameInput& input);

  private:
    std::string m_file;
    std::function<void(Answer)> m_use;
    bool m_isNew = false;  // since the last Draw
};

}  // namespace raygraph::editor
