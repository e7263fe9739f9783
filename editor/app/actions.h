// Lists the actions of keys and menus. Each is stated once: the key bindings, the menus, the help and
// docs/editor.md all follow this table. Threads: constants and pure functions, for any thread.
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
    Path,
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
    Count  // the number of actions
};

struct KeyPress {
    Key key;
    bool isControl = false, isShift = false;

    bool operator==(const KeyPress&) const = default;
};
std::string KeyText(const KeyPress& press);  // e.g. "Ctrl+Shift+S"

enum class Menu : uint8_t { None, FileMenu, EditMenu, CameraMenu, AnimationMenu, PanelMenu };

struct ActionRow {
    Action action;
    Menu menu = Menu::None;
    const char* label = "";                            // text of the menu item or the button
    std::array<std::optional<KeyPress>, 2> keys = {};  // alternatives
    const char* help = "";                             // shown for actions with keys
    bool beginsGroup = false;                          // a separator precedes it in its menu
    bool Panels::*panel = nullptr;                     // the panel that it shows or hides; null: none
};
// Returns a row per Action, in the order of the enum; menus list their actions in this order.
std::span<const ActionRow> Actions();
const ActionRow& Row(Action action);
std::string KeysText(const ActionRow& row);  // e.g. "Ctrl+Y, Ctrl+Shift+Z"; "" without keys

// Returns the action that is bound to a key. Shift is compared only where it tells two actions apart.
std::optional<Action> ActionOf(const KeyPress& press);

// Returns the rows of the help panel: a key or a mouse gesture, and its effect.
std::vector<std::pair<std::string, std::string>> HelpRows();

}  // namespace raygraph::editor
