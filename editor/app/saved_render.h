// The data of a picture that the program writes as .exr for the editor.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "editor/viewport/capture.h"

namespace raygraph::editor {

struct SavedRender {
    viewport::CaptureResult picture;
    // Of the frame that was captured
    std::string sceneFile;        // without folders; "": none
    std::string environmentFile;  // "": no map
    std::string device, driver;
};

// Error{Io} naming the file.
using SaveRender = std::function<void(const std::filesystem::path& file, SavedRender&& render)>;

}  // namespace raygraph::editor
