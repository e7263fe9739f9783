// Makes a render of a viewport's picture: its .exr is as `render` writes it, and can be resumed.
#pragma once

#include <optional>
#include <string>

#include "editor/session/session.h"
#include "editor/viewport/capture.h"

namespace raygraph::editor {

// Names what a picture shows, in the terms of a render.
struct ShownScene {
    session::SceneInput input;  // without the data
    std::optional<double> at;   // time of the animations; none: the rest pose
    std::string clips;          // the clips in effect, see scene::FindClips
};

// Returns the picture with the settings that reproduce it on the command line, since the camera was moved by
// hand. Albedo and normals are those of the pixels' centers, and have no sums.
session::RenderFile RenderOf(viewport::CaptureResult&& picture, const ShownScene& shown,
                             const rhi::DeviceInfo& device);

}  // namespace raygraph::editor
