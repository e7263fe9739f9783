#include "editor/app/actions.h"

#include <algorithm>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::editor {

namespace {

// clang-format off
constexpr ActionRow kActions[] = {
    {Action::Open, "open", Menu::FileMenu, "Open...", {KeyPress{Key::O, true}},
     "open a scene or an environment"},
    {Action::SaveScene, "save-scene", Menu::FileMenu, "Save scene", {KeyPress{Key::S, true}},
     "save the scene with its edits, over its file"},
    {Action::SaveSceneAs, "save-scene-as", Menu::FileMenu, "Save scene as...", {KeyPress{Key::S, true, true}},
     "save the scene with its edits under another name"},
    {Action::SavePicture, "save-picture", Menu::FileMenu, "Save picture...", {KeyPress{Key::E, true}},
     "save the picture as .png or .exr", true},
    {Action::Screenshot, "screenshot", Menu::FileMenu, "Screenshot", {KeyPress{Key::F12}},
     "save the picture in the current folder, as SCENE-0001.png and so on"},
    {Action::RenderImage, "render-image", Menu::FileMenu, "Render image...", {KeyPress{Key::E, true, true}},
     "render pictures in any size, beside the editor"},
    {Action::Quit, "quit", Menu::FileMenu, "Quit", {KeyPress{Key::Q, true}}, "quit", true},
    {Action::Undo, "undo", Menu::EditMenu, "Undo", {KeyPress{Key::Z, true}}, "undo"},
    {Action::Redo, "redo", Menu::EditMenu, "Redo", {KeyPress{Key::Y, true}, KeyPress{Key::Z, true, true}},
     "redo"},
    {Action::Duplicate, "duplicate", Menu::EditMenu, "Duplicate", {KeyPress{Key::D, true}},
     "duplicate the selection", true},
    {Action::Delete, "delete", Menu::EditMenu, "Delete", {KeyPress{Key::Delete}}, "delete the selection"},
    {Action::Rename, "rename", Menu::EditMenu, "Rename", {KeyPress{Key::F2}}, "rename the selection"},
    {Action::Hide, "hide", Menu::EditMenu, "Hide or show", {KeyPress{Key::H}}, "hide or show the selection"},
    {Action::AddMenu, "add", Menu::None, "", {KeyPress{Key::A, false, true}},
     "add a light, an empty node or a camera"},
    {Action::AddPoint, "add-point", Menu::AddMenu, "Point light", {}, "add a point light"},
    {Action::AddSpot, "add-spot", Menu::AddMenu, "Spot light", {}, "add a spot light"},
    {Action::AddDirectional, "add-directional", Menu::AddMenu, "Directional light", {},
     "add a directional light"},
    {Action::AddEmpty, "add-empty", Menu::AddMenu, "Empty", {}, "add an empty node", true},
    {Action::AddCamera, "add-camera", Menu::AddMenu, "Camera from this view", {},
     "add the present view as a camera of the scene"},
    {Action::Frame, "frame", Menu::CameraMenu, "Frame", {KeyPress{Key::F}},
     "frame the selection or the whole scene"},
    {Action::SceneCamera, "scene-camera", Menu::CameraMenu,
     "Scene's camera", {KeyPress{Key::Home}, KeyPress{Key::Digit0}},
     "look through the scene's camera"},
    {Action::Front, "front", Menu::CameraMenu, "Front", {KeyPress{Key::Digit1}},
     "look from the front, along -z", true},
    {Action::Back, "back", Menu::CameraMenu, "Back", {KeyPress{Key::Digit1, true}}, "look from the back"},
    {Action::Right, "right", Menu::CameraMenu, "Right", {KeyPress{Key::Digit3}},
     "look from the right, along -x"},
    {Action::Left, "left", Menu::CameraMenu, "Left", {KeyPress{Key::Digit3, true}}, "look from the left"},
    {Action::Top, "top", Menu::CameraMenu, "Top", {KeyPress{Key::Digit7}}, "look from above, along -y"},
    {Action::Bottom, "bottom", Menu::CameraMenu, "Bottom", {KeyPress{Key::Digit7, true}}, "look from below"},
    {Action::Orthographic, "orthographic", Menu::CameraMenu, "Orthographic", {KeyPress{Key::Digit5}},
     "orthographic or perspective", true},
    {Action::PickFocus, "pick-focus", Menu::CameraMenu, "Focus on...", {KeyPress{Key::F, false, true}},
     "focus the lens on what is clicked next"},
    {Action::CopyCamera, "copy-camera", Menu::CameraMenu, "Copy as --camera", {KeyPress{Key::C, true, true}},
     "copy the view as --camera of the command line", true},
    {Action::CopyCommand, "copy-command", Menu::CameraMenu, "Copy as command",
     {KeyPress{Key::R, true, true}}, "copy the command that renders this picture"},
    {Action::Play, "play", Menu::AnimationMenu, "Play", {KeyPress{Key::Space}},
     "play or pause the animation"},
    {Action::Stop, "stop", Menu::AnimationMenu, "Stop", {KeyPress{Key::Space, false, true}},
     "stop the animation: back to the rest pose"},
    {Action::Loop, "loop", Menu::AnimationMenu, "Loop", {},
     "whether the animation starts again at its end", true},
    {Action::Hierarchy, "hierarchy", Menu::PanelMenu, "Hierarchy", {},
     "the hierarchy", false, &Panels::hierarchy},
    {Action::Inspector, "inspector", Menu::PanelMenu, "Inspector", {KeyPress{Key::N}}, "the inspector", false,
     &Panels::inspector},
    {Action::Timeline, "timeline", Menu::PanelMenu, "Timeline", {KeyPress{Key::K}}, "the timeline", false,
     &Panels::timeline},
    {Action::Statistics, "statistics", Menu::PanelMenu, "Statistics", {KeyPress{Key::T}}, "statistics", false,
     &Panels::statistics},
    {Action::Graph, "graph", Menu::PanelMenu, "Render graph", {KeyPress{Key::G}}, "the frame's plan", false,
     &Panels::graph},
    {Action::Log, "log", Menu::PanelMenu, "Log", {KeyPress{Key::L}}, "the log", false, &Panels::log},
    {Action::Path, "path", Menu::PanelMenu, "Path of a pixel", {KeyPress{Key::I}},
     "the path of the pixel that is clicked", false, &Panels::path},
    {Action::Icons, "icons", Menu::PanelMenu, "Icons of lights and cameras", {},
     "icons of lights and cameras in the picture, which a click selects", false, &Panels::icons},
    {Action::Help, "help", Menu::PanelMenu, "Help and keys", {KeyPress{Key::F1}},
     "this list, where keys are changed",
     false, &Panels::help},
    {Action::Raster, "raster", Menu::None, "", {KeyPress{Key::V}}, "raster, and back"},
    {Action::Wipe, "wipe", Menu::None, "", {KeyPress{Key::C}}, "wipe, and back"},
    {Action::NextView, "next-view", Menu::None, "", {KeyPress{Key::Tab}}, "next view"},
    {Action::Move, "move", Menu::None, "Move", {KeyPress{Key::W}}, "handles that move"},
    {Action::Rotate, "rotate", Menu::None, "Rotate", {KeyPress{Key::E}}, "handles that rotate"},
    {Action::Scale, "scale", Menu::None, "Scale", {KeyPress{Key::R}}, "handles that scale"},
    {Action::Space, "space", Menu::None, "", {KeyPress{Key::X}}, "axes of the handles: world or local"},
    {Action::Pivot, "pivot", Menu::None, "", {KeyPress{Key::P}},
     "place of the handles: the middle of the selection or its origin"},
    {Action::Cancel, "cancel", Menu::None, "", {KeyPress{Key::Escape}},
     "close what is open; else undo the drag; else clear the selection"},
    {Action::ReloadShaders, "reload-shaders", Menu::None, "", {KeyPress{Key::F5}},
     "reload shaders, from --shaders FOLDER"},
};
// clang-format on

// KeyPreset::Blender changes these keys, and takes them from other actions.
constexpr std::pair<Action, Keys> kBlenderKeys[] = {
    {Action::Move, {KeyPress{Key::G}}},
    {Action::Rotate, {KeyPress{Key::R}}},
    {Action::Scale, {KeyPress{Key::S}}},
    {Action::Duplicate, {KeyPress{Key::D, false, true}, KeyPress{Key::D, true}}},
    {Action::Delete, {KeyPress{Key::X}, KeyPress{Key::Delete}}},
    {Action::Frame, {KeyPress{Key::Period}, KeyPress{Key::Home}}},
    {Action::SceneCamera, {KeyPress{Key::Digit0}}},
    {Action::Redo, {KeyPress{Key::Z, true, true}}},
};

constexpr bool AreActionsInOrder() {
    size_t place = 0;
    for (const ActionRow& row : kActions)
        if (row.action != static_cast<Action>(place++)) return false;
    return place == static_cast<size_t>(Action::Count);
}
static_assert(AreActionsInOrder(), "each action needs its row, in the order of the enumerators");

constexpr bool HasMenuItemPerPanel() {
    size_t panels = 0;
    for (const ActionRow& row : kActions) panels += row.menu == Menu::PanelMenu && row.panel != nullptr;
    for (const PanelName& panel : kPanels) {
        size_t count = 0;
        for (const ActionRow& row : kActions) count += row.panel == panel.isShown;
        if (count != 1) return false;
    }
    return panels == std::size(kPanels);
}
static_assert(HasMenuItemPerPanel(), "each panel needs one action, in the menu of panels");

constexpr bool HasUniqueKeys() {
    for (const ActionRow& a : kActions)
        for (const ActionRow& b : kActions)
            for (const auto& key : a.keys)
                for (const auto& other : b.keys)
                    if (&key != &other && key && key == other) return false;
    return true;
}
static_assert(HasUniqueKeys(), "a key asks for two actions");

}  // namespace

// --- Keys and their texts ---

std::string KeyText(const KeyPress& press) {
    return std::string(press.isControl ? "Ctrl+" : "") + (press.isShift ? "Shift+" : "") + Name(press.key);
}

Modified ModifiedFromText(std::string_view text) {
    Modified modified;
    for (size_t plus = text.find('+'); plus != std::string_view::npos; plus = text.find('+')) {
        const std::string_view modifier = text.substr(0, plus);
        const bool isControl = IsSameName(modifier, "ctrl");
        if (!isControl && !IsSameName(modifier, "shift"))
            throw MakeError(ErrorKind::Usage, "there is no modifier \"{}\"", Printable(modifier));
        (isControl ? modified.isControl : modified.isShift) = true;
        text.remove_prefix(plus + 1);
    }
    modified.name = text;
    return modified;
}

KeyPress KeyFromText(std::string_view text) {
    const Modified modified = ModifiedFromText(text);
    return {KeyFromName(modified.name), modified.isControl, modified.isShift};
}

// --- The table and the bindings ---

std::span<const ActionRow> Actions() {
    return kActions;
}

const ActionRow& Row(Action action) {
    return kActions[static_cast<size_t>(action)];
}

KeyBindings::KeyBindings(KeyPreset preset) : m_preset(preset) {
    for (const ActionRow& row : kActions) m_keys[static_cast<size_t>(row.action)] = row.keys;
    if (preset == KeyPreset::Blender)
        for (const auto& [action, keys] : kBlenderKeys) Bind(action, keys);
}

std::string KeyBindings::TextOf(Action action) const {
    std::string text;
    for (const std::optional<KeyPress>& key : Of(action))
        if (key) text += (text.empty() ? "" : ", ") + KeyText(*key);
    return text;
}

std::optional<Action> KeyBindings::ActionOf(const KeyPress& press) const {
    std::optional<Action> withoutShift;
    for (const ActionRow& row : kActions)
        for (const std::optional<KeyPress>& key : Of(row.action)) {
            if (key == press) return row.action;
            if (key == KeyPress{press.key, press.isControl}) withoutShift = row.action;
        }
    return withoutShift;
}

void KeyBindings::Bind(Action action, const Keys& keys) {
    for (Keys& others : m_keys) {
        for (std::optional<KeyPress>& key : others)
            if (key && std::ranges::count(keys, key) > 0) key.reset();
        if (!others[0]) std::swap(others[0], others[1]);
    }
    m_keys[static_cast<size_t>(action)] = keys;
}

std::vector<Action> KeyBindings::Changed() const {
    const KeyBindings preset(m_preset);
    std::vector<Action> changed;
    for (const ActionRow& row : kActions)
        if (Of(row.action) != preset.Of(row.action)) changed.push_back(row.action);
    return changed;
}

std::vector<std::pair<std::string, std::string>> GestureRows(KeyPreset preset) {
    const bool isBlender = preset == KeyPreset::Blender;
    return {
        {isBlender ? "middle drag, left drag" : "left drag",
         "orbit; left on a handle of the selection: move, rotate or scale it (Ctrl: in steps)"},
        {isBlender ? "Shift + middle or left drag" : "middle drag, Shift + left drag", "pan"},
        {"wheel", "closer, farther"},
        {"right drag", "look around; with W A S D Q E fly (Shift: fast, Ctrl: slow)"},
        {"click", "select the object under the pointer, with its material"},
        {"Ctrl + click", "in the hierarchy: select one more, or one less"},
        {"Shift + click", "in the hierarchy: select all rows from the last one (Ctrl: besides the others)"},
        {"Up, Down, Home, End",
         "in the hierarchy, once it was clicked: select another row (Shift: all up to it)"},
        {"Left, Right", "in the hierarchy, likewise: close and open the row"},
        {"Shift + 1 to 9", "camera bookmark; with Ctrl set it"},
    };
}

}  // namespace raygraph::editor
