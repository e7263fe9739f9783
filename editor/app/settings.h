// Holds the editor's stored settings: panels, window, keys, view settings, recent files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "editor/app/actions.h"
#include "editor/app/gizmo.h"
#include "editor/viewport/view_settings.h"
#include "rhi/format.h"

namespace raygraph::editor {

// Bounds a number among the view settings, in the file and in the panel.
struct Range {
    float min, max;
};
inline constexpr Range kExposureRange{-8.0f, 8.0f};
inline constexpr Range kWhitePointRange{float{passes::kMinWhitePoint}, float{passes::kMaxWhitePoint}};
inline constexpr Range kWipeRange{0.0f, 1.0f};
inline constexpr Range kErrorRange{0.01f, 2.0f};
inline constexpr Range kPanelRange{0.0f, 4096.0f}, kInspectorRange{0.1f, 0.9f};

struct Settings {
    Panels panels;
    PanelSizes panelSizes;
    rhi::Extent2D window{1440, 900};     // points
    std::optional<viewport::View> view;  // none: the user has not chosen one
    viewport::ShowSettings show;         // stored: compared, isDenoised, wipe, exposure, operator, maxError
    int whitePoint = static_cast<int>(passes::kDisplayWhitePoint);  // kelvin
    viewport::MotionView whileMoving = viewport::MotionView::Auto;
    KeyBindings keys;
    GizmoTool tool = GizmoTool::Move;
    GizmoSpace toolSpace = GizmoSpace::World;
    GizmoPivot pivot = GizmoPivot::Middle;
    std::vector<std::filesystem::path> recent;  // newest first, absolute, at most kMaxRecent

    static constexpr size_t kMaxRecent = 10;
    // Moves a file to the front of `recent`.
    void AddRecentFile(const std::filesystem::path& file);
    bool operator==(const Settings&) const = default;
};

// Returns $XDG_CONFIG_HOME/raygraph, else ~/.config/raygraph; "" if neither variable is set.
std::filesystem::path ConfigFolder();

// Reads the folder's editor.json; returns the defaults if there is none. A file that cannot be read is
// ignored as a whole, and `message` gets one line that says why.
Settings ReadSettings(const std::filesystem::path& folder, std::string& message);
// Writes the folder's editor.json. Makes the folder if need be. Throws Error{Io}.
void WriteSettings(const std::filesystem::path& folder, const Settings& settings);

}  // namespace raygraph::editor
