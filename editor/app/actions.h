// Lists the actions of keys and menus. Each is stated once: the key bindings, the menus, the help and
// docs/editor.md all follow this table. Threads: constants and pure functions, for any thread.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "editor/app/input.h"
#include "editor/app/panel_switches.h"
#include "shaders/shared/choice.h"

namespace raygraph::editor {

enum class Action : uint8_t {
    Open,
    SaveScene,
    SaveSceneAs,
    SavePicture,
    Screenshot,
    RenderImage,
    Quit,
    Undo,
    Redo,
    Duplicate,
    Delete,
    Rename,
    Hide,
    AddMenu,
    AddPoint,
    AddSpot,
    AddDirectional,
    AddEmpty,
    AddCamera,
    Frame,
    SceneCamera,
    Front,
    Back,
    Right,
    Left,
    Top,
    Bottom,
    Orthographic,
    PickFocus,
    CopyCamera,
    CopyCommand,
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
    Icons,
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
inline constexpr size_t kActionCount = static_cast<size_t>(Action::Count);

struct KeyPress {
    Key key;
    bool isControl = false, isShift = false;

    bool operator==(const KeyPress&) const = default;
};
std::string KeyText(const KeyPress& press);  // e.g. "Ctrl+Shift+S"
// A text such as "ctrl+shift+NAME", in any case.
struct Modified {
    std::string_view name;  // the part after the modifiers
    bool isControl = false, isShift = false;
};
// Throws Error{Usage} for another modifier.
Modified ModifiedFromText(std::string_view text);
// Returns the key of a text as KeyText returns it, in any case. Throws Error{Usage} for another text.
KeyPress KeyFromText(std::string_view text);

enum class Menu : uint8_t { None, FileMenu, EditMenu, AddMenu, CameraMenu, AnimationMenu, PanelMenu };

using Keys = std::array<std::optional<KeyPress>, 2>;  // alternatives; the first is shown in menus

struct ActionRow {
    Action action;
    const char* name = "";  // in the file of settings
    Menu menu = Menu::None;
    const char* label = "";         // text of the menu item or the button
    Keys keys = {};                 // by KeyPreset::Raygraph
    const char* help = "";          // what it does
    bool beginsGroup = false;       // a separator precedes it in its menu
    bool Panels::*panel = nullptr;  // the panel that it shows or hides; null: none
};
// Returns a row per Action, in the order of the enum; menus list their actions in this order.
std::span<const ActionRow> Actions();
const ActionRow& Row(Action action);

//   Raygraph: W, E and R are move, rotate and scale, as in many game engines
//   Blender: G, R and S are; the middle button orbits
#define RAYGRAPH_KEY_PRESETS(X, Of)    \
    X(Of, Raygraph, 0, "raygraph", "") \
    X(Of, Blender, 1, "blender", "")
RAYGRAPH_CHOICE(KeyPreset, RAYGRAPH_KEY_PRESETS)

// KeyBindings says which keys ask for which action: those of a preset, with the user's changes.
class KeyBindings {
  public:
    KeyBindings() : KeyBindings(KeyPreset::Raygraph) {}
    explicit KeyBindings(KeyPreset preset);

    KeyPreset Preset() const { return m_preset; }
    const Keys& Of(Action action) const { return m_keys[static_cast<size_t>(action)]; }
    // Returns, for example, "Ctrl+Y, Ctrl+Shift+Z"; "" without keys.
    std::string TextOf(Action action) const;
    // Returns the action that is bound to a key. Shift is compared only where it tells two actions apart.
    std::optional<Action> ActionOf(const KeyPress& press) const;
    // Gives the action these keys, and takes them from the others.
    void Bind(Action action, const Keys& keys);
    // Returns the actions whose keys are not those of the preset.
    std::vector<Action> Changed() const;

    bool operator==(const KeyBindings&) const = default;

  private:
    KeyPreset m_preset;
    std::array<Keys, kActionCount> m_keys;
};

// Returns the rows of the help: what is done with the mouse, or with keys that are held or numbered, and its
// effect.
std::vector<std::pair<std::string, std::string>> GestureRows(KeyPreset preset);

}  // namespace raygraph::editor
