// raygraph edit: the editor in a window, or run by a script.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "editor/app/editor.h"
#include "editor/app/log_history.h"
#include "editor/viewport/view_settings.h"
#include "renderer/scene/round_primitives.h"
#include "rhi/device.h"

namespace raygraph::editor {

struct EditOptions {
    std::filesystem::path scene;                // "": opens empty
    std::string variant = {};                   // of it, by name or index; "": none
    std::string camera = {};                    // to look through first, as of scene::ChooseView
    std::filesystem::path root = {};            // of this and all later files: scene::LoadOptions::root
    std::filesystem::path environment = {};     // map to open, .hdr or .exr; "": none
    DefaultLight light = DefaultLight::Auto;    // of scenes that are opened without a map
    std::optional<viewport::View> view = {};    // none: as it was left, or path-traced
    std::optional<passes::View> surface = {};   // likewise, of View::Surface
    scene::PointsAndLines pointsAndLines = {};  // radii of those in this and all later files; off: left out
    std::filesystem::path script;               // "": a window; else runs this script without one
    std::filesystem::path shaders;              // folder of sources to reload from; "": none
    uint64_t textureBudget = 0;                 // as GpuSceneDesc
    // What the log panel shows: it is given what devices say; null: nothing.
    std::shared_ptr<LogHistory> log = {};
};

// Opens the device, with these extensions as DeviceDesc::surfaceExtensions.
using OpenDevice = std::function<std::unique_ptr<rhi::Device>(std::vector<std::string> surfaceExtensions)>;

// The window of RunFrames.
struct FrameSource {
    std::function<FrameInput(double seconds)> poll;  // as Window::Poll
    std::function<void(const std::string&)> setTitle;
};
// Frames until the user quits; events are taken while the device is busy. The Error of a frame (a lost
// device, exhausted memory) ends them; unsaved edits are then written beside the scene's file
// (Document::SaveBeside), and the Error says so.
void RunFrames(Editor& editor, Screen& screen, const FrameSource& window);

// Runs until the user quits, or the script ends. Error{NoDevice} without a display or a device,
// Error{BadInput} for a script that is malformed or whose expectation does not hold, and for an environment
// whose name does not end as one. What cannot be loaded is said in the status line.
void RunEditor(const EditOptions& options, const OpenDevice& openDevice);

}  // namespace raygraph::editor
