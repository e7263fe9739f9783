// Implements `raygraph edit`: the editor in a window, or run by a script.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "editor/app/editor.h"
#include "editor/app/log_history.h"
#include "editor/app/scene_view.h"
#include "editor/viewport/view_settings.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "rhi/device.h"

namespace raygraph::editor {

struct EditOptions {
    std::filesystem::path scene;             // "": starts without a scene
    std::string variant = {};                // name or index of a variant of the scene; "": none
    std::filesystem::path root = {};         // scene::LoadOptions::root of this file and all later ones
    std::filesystem::path environment = {};  // the map that changeView chooses; "": none
    ChangeView changeView = {};              // applies what is given of the first view; null: nothing
    // None: the stored view; in a window without one, Workspace::ChooseViewByTime.
    std::optional<viewport::View> view = {};
    std::optional<passes::View> surface = {};         // view of View::Surface; none: the stored one
    std::optional<viewport::Compared> compared = {};  // what views compare; none: the stored one
    scene::PointsAndLines pointsAndLines = {};        // radii in this and all later files; off: left out
    std::filesystem::path script;                     // runs this script without a window; "": opens a window
    std::filesystem::path shaders;                    // folder of shader sources for hot reload; "": none
    uint64_t textureBudget = 0;                       // in bytes, see GpuSceneDesc
    std::vector<std::string> render = {};             // EditorOptions::render
    // The log panel shows this; devices add their messages to it. Null: the panel is empty.
    std::shared_ptr<LogHistory> log = {};
};

// Opens the device with these extensions (DeviceDesc::surfaceExtensions).
using OpenDevice = std::function<std::unique_ptr<rhi::Device>(std::vector<std::string> surfaceExtensions)>;

// RunFrames takes its input from this.
struct FrameSource {
    std::function<FrameInput(double seconds)> poll;  // see Window::Poll
    std::function<void(const std::string&)> setTitle;
};
// Runs frames until the user quits; events are taken while the device is busy. An Error of a frame (a lost
// device, exhausted memory) ends the loop; unsaved edits are then written beside the scene's file
// (Document::SaveRecoveryCopy), and the Error says so.
void RunFrames(Editor& editor, Screen& screen, const FrameSource& window);

// Runs until the user quits or the script ends. Throws Error{NoDevice} without a display or a device, and
// Error{BadInput} for a malformed script, for an expectation that does not hold, and for an environment whose
// file name has the wrong extension. The status line reports files that cannot be loaded.
void RunEditor(const EditOptions& options, const OpenDevice& openDevice);

// Returns the keys and what the mouse does, a line each.
std::string KeyList();

}  // namespace raygraph::editor
