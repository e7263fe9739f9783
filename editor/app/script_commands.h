// Parses a script's commands before any is run, so that a mistake in its last line is found before its first
// frame. script.h lists the commands. Threads: plain values and pure functions, for any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "editor/app/input.h"
#include "editor/viewport/view_settings.h"

namespace raygraph::editor {

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
};
struct ScrollWheel {
    float notches;
};
struct TypeText {
    std::u32string text;
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
        Time,
        Asking,
        Leaving,
        Playing,
        SamplesBelow,
        SamplesAbove
    };
    Of of;
    std::string text;     // argument of Selected, Variant, Message and Time
    uint32_t number = 0;  // argument of Edits and Samples; Asking, Leaving, Playing: 1 is yes, 0 is no
    viewport::View view = viewport::View::PathTraced;
};

using ScriptCommand =
    std::variant<SetSize, SetScale, DropFile, CloseWindow, PressKey, MoveMouse, HoldButton, ScrollWheel,
                 TypeText, AdvanceFrames, WaitUntilDone, WaitForSamples, SaveShown, SetBudget,
                 UseConfigFolder, SaveSceneFile, ShowView, ShowVariant, PlayFor, ShowTime, StopPlaying,
                 ChooseClips, SetBaseColor, Expectation>;

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

}  // namespace raygraph::editor
