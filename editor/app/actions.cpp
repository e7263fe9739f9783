#include "editor/app/actions.h"

namespace raygraph::editor {

namespace {

// clang-format off
constexpr ActionRow kActions[] = {
    {Action::Open, Menu::FileMenu, "Open...", {KeyPress{Key::O, true}}, "open a scene or an environment"},
    {Action::SaveScene, Menu::FileMenu, "Save scene as...", {KeyPress{Key::S, true, true}},
     "save the scene with its edits"},
    {Action::SavePicture, Menu::FileMenu, "Save picture...", {KeyPress{Key::S, true}},
     "save the picture as .png or .exr", true},
    {Action::Screenshot, Menu::FileMenu, "Screenshot", {KeyPress{Key::F12}},
     "screenshot: raygraph.png in the current folder"},
    {Action::Quit, Menu::FileMenu, "Quit", {KeyPress{Key::Q, true}}, "quit", true},
    {Action::Undo, Menu::EditMenu, "Undo", {KeyPress{Key::Z, true}}, "undo"},
    {Action::Redo, Menu::EditMenu, "Redo", {KeyPress{Key::Y, true}, KeyPress{Key::Z, true, true}}, "redo"},
    {Action::Hide, Menu::EditMenu, "Hide or show", {KeyPress{Key::H}}, "hide or show the selection"},
    {Action::Frame, Menu::CameraMenu, "Frame", {KeyPress{Key::F}}, "frame the selection or the whole scene"},
    {Action::SceneCamera, Menu::None, "", {KeyPress{Key::Home}}, "the scene's camera"},
    {Action::Play, Menu::AnimationMenu, "Play", {KeyPress{Key::Space}}, "play or pause the animation"},
    {Action::Stop, Menu::AnimationMenu, "Stop", {KeyPress{Key::Space, false, true}},
     "stop the animation: back to the rest pose"},
    {Action::Loop, Menu::AnimationMenu, "Loop", {}, "", true},
    {Action::Hierarchy, Menu::PanelMenu, "Hierarchy", {}, "", false, &Panels::hierarchy},
    {Action::Inspector, Menu::PanelMenu, "Inspector", {}, "", false, &Panels::inspector},
    {Action::Timeline, Menu::PanelMenu, "Timeline", {KeyPress{Key::K}}, "the timeline", false,
     &Panels::timeline},
    {Action::Statistics, Menu::PanelMenu, "Statistics", {KeyPress{Key::T}}, "statistics", false,
     &Panels::statistics},
    {Action::Graph, Menu::PanelMenu, "Render graph", {KeyPress{Key::G}}, "the frame's plan", false,
     &Panels::graph},
    {Action::Log, Menu::PanelMenu, "Log", {KeyPress{Key::L}}, "the log", false, &Panels::log},
    {Action::Path, Menu::PanelMenu, "Path of a pixel", {KeyPress{Key::E}},
     "the path of the pixel that is clicked", false, &Panels::path},
    {Action::Help, Menu::PanelMenu, "Help", {KeyPress{Key::F1}}, "this help", false, &Panels::help},
    {Action::Raster, Menu::None, "", {KeyPress{Key::R}}, "raster, and back"},
    {Action::Wipe, Menu::None, "", {KeyPress{Key::W}}, "wipe, and back"},
    {Action::NextView, Menu::None, "", {KeyPress{Key::Tab}}, "next view"},
    {Action::Move, Menu::None, "Move", {KeyPress{Key::Z}}, "handles that move"},
    {Action::Rotate, Menu::None, "Rotate", {KeyPress{Key::X}}, "handles that rotate"},
    {Action::Scale, Menu::None, "Scale", {KeyPress{Key::C}}, "handles that scale"},
    {Action::Space, Menu::None, "", {KeyPress{Key::V}}, "axes of the handles: world or local"},
    {Action::Pivot, Menu::None, "", {KeyPress{Key::P}},
     "place of the handles: the middle of the selection or its origin"},
    {Action::Cancel, Menu::None, "", {KeyPress{Key::Escape}}, "undo the drag; else clear the selection"},
    {Action::ReloadShaders, Menu::None, "", {KeyPress{Key::F5}}, "reload shaders, from --shaders FOLDER"},
};
// clang-format on

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

// Gestures are done with the mouse, or with keys that are held or numbered.
constexpr std::pair<const char*, const char*> kGestures[] = {
    {"left drag", "orbit; on a handle of the selection: move, rotate or scale it (Ctrl: in steps)"},
    {"middle drag, Shift + left drag", "pan"},
    {"wheel", "closer, farther"},
    {"right drag", "look around; with W A S D Q E fly (Shift: fast, Ctrl: slow)"},
    {"click", "select the object under the pointer, with its material"},
    {"1 to 9", "camera bookmark; Ctrl and the digit sets it"},
};

}  // namespace

std::string KeyText(const KeyPress& press) {
    return std::string(press.isControl ? "Ctrl+" : "") + (press.isShift ? "Shift+" : "") + Name(press.key);
}

std::span<const ActionRow> Actions() {
    return kActions;
}

const ActionRow& Row(Action action) {
    return kActions[static_cast<size_t>(action)];
}

std::string KeysText(const ActionRow& row) {
    std::string text;
    for (const std::optional<KeyPress>& key : row.keys)
        if (key) text += (text.empty() ? "" : ", ") + KeyText(*key);
    return text;
}

std::optional<Action> ActionOf(const KeyPress& press) {
    std::optional<Action> withoutShift;
    for (const ActionRow& row : kActions)
        for (const std::optional<KeyPress>& key : row.keys) {
            if (key == press) return row.action;
            if (key == KeyPress{press.key, press.isControl}) withoutShift = row.action;
        }
    return withoutShift;
}

std::vector<std::pair<std::string, std::string>> HelpRows() {
    std::vector<std::pair<std::string, std::string>> rows(std::begin(kGestures), std::end(kGestures));
    for (const ActionRow& row : kActions)
        if (row.keys[0]) rows.emplace_back(KeysText(row), row.help);
    return rows;
}

}  // namespace raygraph::editor
