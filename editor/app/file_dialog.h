// FileDialog asks for the path of a file: by the desktop's own dialog, if zenity is there, else by a list of
// the folder's files. Main thread only; the desktop's dialog is a process of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/os.h"

namespace raygraph::editor {

struct FolderEntry {
    std::string name;
    bool isFolder = false;
    uintmax_t bytes = 0;

    bool operator==(const FolderEntry&) const = default;
};
// Returns what is in the folder, folders first, each in alphabetical order without case: files that end in
// one of the extensions (".gltf", in any case), or all files if there is none. Hidden ones are left out, and
// all if the folder cannot be read.
std::vector<FolderEntry> ListFolder(const std::filesystem::path& folder,
                                    std::span<const std::string_view> extensions);
// Returns the path with ~ at its start replaced by the home folder.
std::filesystem::path ExpandHome(std::string_view text);
// Returns the text, which is completed as far as the names of its folder that start as it does agree; a
// folder's name gets its "/".
std::string CompletedPath(std::string_view text);

struct FileQuestion {
    enum class For : uint8_t { Reading, Writing };
    std::string title;
    std::string hint;  // one line
    For purpose = For::Reading;
    std::filesystem::path suggestion;
    std::vector<std::string_view> extensions;  // of the files that are listed
};

class FileDialog {
  public:
    // Returns why the path is not accepted, as one line: the dialog stays with it. "": it is, and the dialog
    // closes.
    using Use = std::function<std::string(const std::filesystem::path&)>;

    // Opens the dialog until the user has answered; it replaces an open one.
    void Ask(FileQuestion question, Use use);
    // Draws the dialog, and passes the answer to `use`. `recent` are files that are offered.
    void Draw(std::span<const std::filesystem::path> recent);
    // Allows or forbids the desktop's dialog: a script types into the list.
    void AllowDesktop(bool isAllowed) { m_allowsDesktop = isAllowed; }
    bool IsOpen() const { return static_cast<bool>(m_use); }

  private:
    void DrawList(std::span<const std::filesystem::path> recent);
    void Enter(const std::filesystem::path& folder);
    void Answer(const std::filesystem::path& path);
    void StartDesktop(const std::filesystem::path& suggestion);

    FileQuestion m_question;
    Use m_use;                   // empty: the dialog is closed
    bool m_isRequested = false;  // the popup is to be opened by the next Draw
    bool m_allowsDesktop = false;
    bool m_showsAll = false;     // files of all kinds are listed
    bool m_focusesName = false;  // the next Draw gives the field of the name the keyboard
    std::filesystem::path m_folder;
    std::vector<FolderEntry> m_entries;  // of m_folder
    std::string m_why;                   // why the last answer was not accepted; "": it was not given
    char m_path[1024] = {};              // as it is typed; a relative one is in m_folder
    std::unique_ptr<os::ChildProcess> m_desktop;  // the desktop's dialog; null: the list is used
};

}  // namespace raygraph::editor
