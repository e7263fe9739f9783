// Says what the editor shows in the words of the command line: the options with which `raygraph render` makes
// the same picture. Threads: main thread only.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "editor/app/workspace.h"

namespace raygraph::editor {

// Returns the shown view as `render` reads it from the words, which differs by rounding: a picture of it has
// the bits of the render.
scene::CameraView RenderedView(const Workspace& work);

// Returns the settings of a render of what is shown in the size of its picture, as `view`.
session::PictureSettings ShownSettings(const Workspace& work, passes::View view);
// The raster view and surfaces are rendered as they are, every other view as the path-traced picture.
session::PictureSettings ShownSettings(const Workspace& work);

// Returns the options of a render with these settings of the open scene: each setting that is not the
// command's default, the environment map, and, if it writes one, how a .png or .jpg shows the picture.
std::vector<std::string> RenderWords(const Workspace& work, const session::PictureSettings& settings,
                                     bool isShown = true);

// Adds an option with its value.
void AddOption(std::vector<std::string>& words, std::string_view name, const std::string& value);
// Returns the path in full: a command may be run from any folder.
std::string FullPath(const std::filesystem::path& file);
// Returns the value of --camera for a camera of the scene as its file has it once edits are saved.
std::string CameraChoice(const Workspace& work, uint32_t camera);
std::vector<std::string> CameraChoices(const Workspace& work);  // for all cameras, in the file's order

// Returns a line for a POSIX shell, which takes each word as it is.
std::string ShellLine(std::span<const std::string> words);

// Returns `--camera "..."` of the shown view.
std::string CameraOption(const Workspace& work);
// Returns the line `raygraph render FILE ...` of the shown view.
std::string RenderCommand(const Workspace& work);

}  // namespace raygraph::editor
