// What the user can ask for by a key or in a menu, each stated once: keys, menus, help and docs/editor.md all
// go by this table. Threads: constants and pure functions, for any thread.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "editor/app/input.h"
#include "editor/app/settings.h"

namespace raygraph::editor {

enum class Action : uint8_t {
    Open,
    SaveScene,
    SavePicture,
    Screenshot,
    Quit,
    Undo,
    Redo,
    Hide,
    Frame,
    SceneCamera,
    Play,
    Stop,
    Loop,
    Hierarchy,
    Inspector,
    Timeline,
    Statistics,
    Graph,
    Log,
    Help,
    Raster,
    Wipe,
    NextView,
    Move,
    Rotate,
    Scale,
    Space,
    Pivot,
    Cancel,
    ReloadShaders,
    Count  // of the above
};

struct KeyPress {
    Key key;
    bool isControl = false, isShift = false;

    bool operator==(const KeyPress&) const = default;
};
std::string KeyText(const KeyPress& press);  // "Ctrl+Shift+S"

enum class Menu : uint8_t { None, FileMenu, EditMenu, CameraMenu, AnimationMenu, PanelMenu };

struct ActionRow {
    Action action;
    Menu menu = Menu::None;
    const char* label = "";                            // in its menu, or on its button
    std::array<std::optional<KeyPress>, 2> keys = {};  // any of them
    const char* help = "";                             // of one with keys
    bool beginsGroup = false;                          // a line above it in its menu
    bool Panels::*panel = nullptr;                     // that it shows or hides
};
// By Action; the order in each menu.
std::span<const ActionRow> Actions();
const ActionRow& Row(Action action);
std::string KeysText(const ActionRow& row);  // "Ctrl+Y, Ctrl+Shift+Z"; "" without

// What a key asks for. Shift counts where it tells two actions apart.
std::optional<Action> ActionOf(const KeyPress& press);

// What the mouse and the keys do, as help shows it: what is pressed, and what for.
std::vector<std::pair<std::string, std::string>> HelpRows();

}  // namespace raygraph::editor
