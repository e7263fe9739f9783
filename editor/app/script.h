// clang-format off
// A script that plays the user: one command a line, '#' starts a comment.
//
//   size 1280x720          of the window, pixels     scale 2           pixels to a point, 0.5 to 8
//   open FILE              as if dropped             key ctrl+z        also shift+: input.h
//   mouse 640 360          moves there               click left        also press, release; right, middle;
//                          ctrl+left, shift+left, ctrl+shift+left: while the keys are held
//   drag left 100 0        presses, moves, lets go   wheel 2           notches
//   text abc               typed                     view raster       a view by its name
//   select NAME, NAME      nodes; the last is the active one
//   frames 10              lets time pass            wait              until loads, picks and files are done
//   samples 64             until the view has all   material base 1 0 0   of what is selected
//   window FILE            saves it as .png          picture FILE      saves the picture, .png or .exr
//   fov 40                 degrees                  aperture 0.05     radius of the lens, meters
//   focus 3                meters                   exposure 1        stops
//   white-point 3200       kelvin                 ground on         a ground below the scene; ground off
//   backdrop blur:10       behind the scene, as `render --backdrop`: map, a color, transparent
//   render 64x48 16 FILE   opens the dialog for renders and fills it in; key enter starts, wait waits for it
//   budget 0               milliseconds of the device that a frame may take; 0: a frame is a sample
//   config FOLDER          settings are read from there, and kept there when the script ends
//   scene FILE             saves the scene, .gltf or .glb
//   compare real-time      what views compare with the path-traced picture; compare raster
//   denoise on             of the path-traced view; denoise off
//   variant NAME           shows it, by name or index; none: the materials without one
//   clips walk:0.3,run     those of the animations that are on; all: all of them
//   play SECONDS           plays for so long, a 60th of a second a frame, then pauses
//   time SECONDS           shows that time           stop              back to the rest pose
//   close                  as the window's button   expect asking yes | leaving no: the question about
//                          unsaved edits, which key S, D or escape answers; whether the editor ends
//   expect selected NAME, NAME | view NAME | variant NAME | message TEXT | edits N | nodes N
//   expect samples-below N | samples-above N | playing yes | time 0.250 | time rest
// clang-format on
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "editor/app/editor.h"
#include "editor/app/input.h"
#include "editor/viewport/view_settings.h"

namespace raygraph::editor {

// --- The commands of a script ---
// They are parsed before any is run, so that a mistake in the last line is found before the first frame.
// Threads: plain values and pure functions, for any thread.

struct SetSize {
    rhi::Extent2D extent;  // pixels
};
struct SetScale {
    float scale;
};
struct DropFile {
    std::filesystem::path file;
};
struct CloseWindow {};
struct PressKey {
    Key key;
    bool isControl, isShift;
};
struct MoveMouse {
    glm::vec2 place;  // pixels
};
// Stands for press, release, click and drag.
struct HoldButton {
    MouseButton button;
    bool isDown, isUp;  // button goes down, then up
    bool isDragged;     // moves by `way` in between
    glm::vec2 way{0.0f};
    bool isControl = false, isShift = false;
};
struct ScrollWheel {
    float notches;
};
struct TypeText {
    std::u32string text;
};
struct SelectNodes {
    std::vector<std::string> names;
};
struct AdvanceFrames {
    uint32_t count;
};
struct WaitUntilDone {};
struct WaitForSamples {
    uint32_t count;
};
struct SaveShown {
    std::filesystem::path file;
    bool isWindow;  // true: the window; false: the picture
};
struct FillRenderDialog {
    rhi::Extent2D size;
    uint32_t samples;
    std::filesystem::path file;
};
struct SetLook {
    enum class Of : uint8_t { FieldOfView, Aperture, Focus, Exposure, WhitePoint };
    Of of;
    float value;
};
struct SetBackdrop {
    std::optional<passes::BackdropSettings> backdrop;
};
struct SetGround {
    bool isOn;
};
struct SetBudget {
    double frameMs;
};
struct UseConfigFolder {
    std::filesystem::path folder;
};
struct SaveSceneFile {
    std::filesystem::path file;
};
struct ShowView {
    viewport::View view;
};
struct CompareWith {
    viewport::Compared compared;
};
struct SetDenoised {
    bool isOn;
};
struct ShowVariant {
    std::string choice;  // name or index
};
struct PlayFor {
    double seconds;
};
struct ShowTime {
    double seconds;
};
struct StopPlaying {};
struct ChooseClips {
    std::string list;  // see scene::FindClips
};
struct SetBaseColor {
    glm::vec3 color;
};
struct Expectation {
    enum class Of : uint8_t {
        Selected,
        View,
        Variant,
        Message,
        Edits,
        Nodes,
        Time,
        Asking,
        Leaving,
        Playing,
        SamplesBelow,
        SamplesAbove
    };
    Of of;
    std::string text;     // argument of Selected, Variant, Message and Time
    uint32_t number = 0;  // argument of Edits, Nodes and Samples; Asking, Leaving, Playing: 1 is yes, 0 is no
    viewport::View view = viewport::View::PathTraced;
};

using ScriptCommand =
    std::variant<SetSize, SetScale, DropFile, CloseWindow, PressKey, MoveMouse, HoldButton, ScrollWheel,
                 TypeText, SelectNodes, AdvanceFrames, WaitUntilDone, WaitForSamples, SaveShown, SetBudget,
                 UseConfigFolder, SaveSceneFile, ShowView, CompareWith, SetDenoised, ShowVariant, PlayFor,
                 ShowTime, StopPlaying, ChooseClips, SetBaseColor, FillRenderDialog, SetLook, SetBackdrop,
                 SetGround, Expectation>;

struct ScriptLine {
    uint32_t number = 0;
    std::string text;  // printable, single spaces
    ScriptCommand command;
};

// Parses every line of the text. Throws Error{BadInput}, e.g. "name:3: smile: there is no such command".
std::vector<ScriptLine> ParseScript(std::string_view text, const std::string& name);

// Throws Error{BadInput} that names the line.
[[noreturn]] void ThrowLineError(const std::string& name, uint32_t number, std::string_view text,
                                 std::string_view why);

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
