// clang-format off
// A script that plays the user: one command a line, '#' starts a comment.
//
//   size 1280x720          of the window, pixels     scale 2           pixels to a point, 0.5 to 8
//   open FILE              as if dropped             key ctrl+z        also shift+; names: input.h
//   mouse 640 360          moves there               click left        also press, release; right, middle
//   drag left 100 0        presses, moves, lets go   wheel 2           notches
//   text abc               typed                     view raster       a view by its name
//   frames 10              lets time pass            wait              until loads, picks and files are done
//   samples 64             until the view has all   material base 1 0 0   of what is selected
//   window FILE            saves it as .png          picture FILE      saves the picture, .png or .exr
//   budget 0               milliseconds of the device that a frame may take; 0: a frame is a sample
//   config FOLDER          settings are read from there, and kept there when the script ends
//   scene FILE             saves the scene, .gltf or .glb
//   variant NAME           shows it, by name or index; none: the materials without one
//   clips walk:0.3,run     those of the animations that are on; all: all of them
//   play SECONDS           plays for so long, a 60th of a second a frame, then pauses
//   time SECONDS           shows that time           stop              back to the rest pose
//   close                  as the window's button   expect asking yes | leaving no: the question about
//                          unsaved edits, which key S, D or escape answers; whether the editor ends
//   expect selected NAME | view NAME | variant NAME | message TEXT | edits N
//   expect samples-below N | samples-above N | playing yes | time 0.250 | time rest
// clang-format on
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "editor/app/editor.h"
#include "editor/app/script_commands.h"

namespace raygraph::editor {

class Script {
  public:
    // Parses the whole file. Throws Error{Io}, or Error{BadInput} that names the first line that is not a
    // command.
    explicit Script(const std::filesystem::path& file);
    // Runs the whole script. Throws Error{BadInput} that names the line whose expectation does not hold.
    void Play(Editor& editor, Screen& screen);

  private:
    void Do(const ScriptLine& line, Editor& editor, Screen& screen);
    void Expect(const ScriptLine& line, const Expectation& expected, Editor& editor) const;
    void Frame(Editor& editor, Screen& screen);
    void PlayAnimation(double seconds, Editor& editor, Screen& screen);
    [[noreturn]] void Fail(const ScriptLine& line, const std::string& why) const;

    std::filesystem::path m_file;
    std::vector<ScriptLine> m_lines;
    FrameInput m_input;
};

}  // namespace raygraph::editor
