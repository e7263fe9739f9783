// A picture of the viewport as a render: its .exr is what `render` writes, and goes on with.
#pragma once

#include "editor/session/session.h"
#include "editor/viewport/capture.h"

namespace raygraph::editor {

// With the settings that the command line would need for it: the camera was moved by hand. `source` names
// what was shown, without the data. Albedo and normals are those of the pixels' centers, and without sums.
session::RenderFile RenderOf(viewport::CaptureResult&& picture, const session::SceneInput& source,
                             const rhi::DeviceInfo& device);

}  // namespace raygraph::editor
