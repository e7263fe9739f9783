// A script that plays the user: one command a line, '#' starts a comment.
//
//   size 1280x720          of the window, in pixels        scale 2      pixels to a point
//   open FILE              as if dropped onto the window   key F5       ctrl+z: with modifiers
//   mouse 640 360          moves there                     press left, release left, click left
//   drag left 100 0        presses, moves in steps, lets go
//   wheel 2                notches                         text abc     typed
//   frames 10              lets time pass                  wait         until loads, builds and picks are
//   done samples 64             until the view has so many      window FILE  saves the window as .png picture
//   FILE           saves the picture as .png       view raster  shows a view by its name material base 1 0 0
//   base colour of what is selected expect selected NAME | view NAME | message TEXT | undo N | edits N |
//   samples-below N
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "editor/app/editor.h"

namespace raygraph::editor {

class Script {
  public:
    // Error{Io}, Error{BadInput} naming the line.
    explicit Script(const std::filesystem::path& file);
    // Plays all of it. Error{BadInput} naming the line whose expectation does not hold.
    void Play(Editor& editor, Screen& screen);

  private:
    struct Line {
        uint32_t number = 0;
        std::vector<std::string> words;
    };
    void Do(const Line& line, Editor& editor, Screen& screen);
    void Expect(const Line& line, Editor& editor) const;
    void Frame(Editor& editor, Screen& screen);
    [[noreturn]] void Fail(const Line& line, const std::string& why) const;

    std::filesystem::path m_file;
    std::vector<Line> m_lines;
    FrameInput m_input;
};

}  // namespace raygraph::editor
