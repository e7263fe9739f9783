// A picture of the viewport as a render: its .exr is what `render` writes, and goes on with.
#pragma once

#include <optional>
#include <string>

#include "editor/session/session.h"
#include "editor/viewport/capture.h"

namespace raygraph::editor {

// What a picture shows, as a render names it.
struct ShownScene {
    session::SceneInput input;  // without the data
    std::optional<double> at;   // the time of its animations; none: its rest pose
    std::string clips;          // which of them, as of scene::FindClips
};

// With the settings that the command line would need for it: the camera was moved by hand. Albedo and normals
// are those of the pixels' centers, and without sums.
session::RenderFile RenderOf(viewport::CaptureResult&& picture, const ShownScene& shown,
                             const rhi::DeviceInfo& device);

}  // namespace raygraph::editor
