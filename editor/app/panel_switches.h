// Says which panels are shown beside the picture, and how large they are. Pure.
#pragma once

#include <iterator>

namespace raygraph::editor {

// Switches the panels beside the picture on and off.
struct Panels {
    bool hierarchy = true;
    bool inspector = true;
    bool timeline = true;  // shown only for scenes with animations
    bool statistics = false;
    bool graph = false;
    bool log = false;
    bool icons = true;  // of lights and cameras, over the picture
    bool path = false;  // while it is shown, clicks explain pixels
    bool help = false;

    bool operator==(const Panels&) const = default;
};
// Gives each panel its name in the file.
struct PanelName {
    const char* name;
    bool Panels::*isShown;
};
inline constexpr PanelName kPanels[] = {
    {"hierarchy", &Panels::hierarchy},   {"inspector", &Panels::inspector}, {"timeline", &Panels::timeline},
    {"statistics", &Panels::statistics}, {"graph", &Panels::graph},         {"log", &Panels::log},
    {"icons", &Panels::icons},           {"path", &Panels::path},           {"help", &Panels::help},
};
// Sizes that the user has given the panels by dragging a border.
struct PanelSizes {
    float left = 0.0f, right = 0.0f;  // widths in points; 0: by the window's
    float lower = 0.0f;               // height in points; 0: by the window's
    float inspector = 0.58f;          // share of the height at the right; the rest is the view panel's

    bool operator==(const PanelSizes&) const = default;
};

static_assert(std::size(kPanels) * sizeof(bool) == sizeof(Panels), "each panel needs its name");

}  // namespace raygraph::editor
