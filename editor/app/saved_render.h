// What the editor hands over to be written as .exr: the program knows the format.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "editor/viewport/capture.h"
#include "renderer/gpu_scene/gpu_scene.h"

namespace raygraph::editor {

struct SavedRender {
    viewport::CaptureResult picture;
    EnvironmentSettings environment;
    std::string sceneFile;        // without folders; "": none
    std::string environmentFile;  // "": no map
    std::string device, driver;
};

// Error{Io} naming the file.
using SaveRender = std::function<void(const std::filesystem::path& file, SavedRender&& render)>;

}  // namespace raygraph::editor
