// The editor's stored settings: panels, window, view settings, recent files.
#pragma once

#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "editor/app/gizmo.h"
#include "editor/viewport/view_settings.h"
#include "rhi/format.h"

namespace raygraph::editor {

// The panels that are shown beside the picture.
struct Panels {
    bool hierarchy = true;
    bool inspector = true;
    bool timeline = true;  // of a scene that has animations
    bool statistics = false;
    bool graph = false;
    bool log = false;
    bool help = false;

    bool operator==(const Panels&) const = default;
};
// Each with its name in the file.
struct PanelName {
    const char* name;
    bool Panels::*isShown;
};
inline constexpr PanelName kPanels[] = {
    {"hierarchy", &Panels::hierarchy}, {"inspector", &Panels::inspector},
    {"timeline", &Panels::timeline},   {"statistics", &Panels::statistics},
    {"graph", &Panels::graph},         {"log", &Panels::log},
    {"help", &Panels::help},
};
static_assert(std::size(kPanels) * sizeof(bool) == sizeof(Panels), "each panel needs its name");

// Of numbers among the view settings, in the file and in the panel.
struct Range {
    float min, max;
};
inline constexpr Range kExposureRange{-8.0f, 8.0f};
inline constexpr Range kWipeRange{0.0f, 1.0f};
inline constexpr Range kErrorRange{0.01f, 2.0f};

struct Settings {
    Panels panels;
    rhi::Extent2D window{1440, 900};  // points
    viewport::ShowSettings show;      // view, wipe, exposure, operator and maxError are stored
    GizmoTool tool = GizmoTool::Move;
    GizmoSpace toolSpace = GizmoSpace::World;
    GizmoPivot pivot = GizmoPivot::Middle;
    std::vector<std::filesystem::path> recent;  // newest first, absolute, at most kMaxRecent

    static constexpr size_t kMaxRecent = 10;
    // Puts a file first.
    void NoteOpened(const std::filesystem::path& file);
    bool operator==(const Settings&) const = default;
};

// $XDG_CONFIG_HOME/raygraph, else ~/.config/raygraph; "" where there is neither.
std::filesystem::path ConfigFolder();

// Of the folder's editor.json; the defaults if there is none. One that cannot be read is ignored as a whole,
// and `message` says why, one line.
Settings ReadSettings(const std::filesystem::path& folder, std::string& message);
// Makes the folder if need be. Error{Io}.
void WriteSettings(const std::filesystem::path& folder, const Settings& settings);

}  // namespace raygraph::editor
