// A picture of the editor as a render's .exr.
#pragma once

#include "editor/app/edit.h"
#include "editor/session/render_file.h"

namespace raygraph::cli {

// With the settings that the command line would need for it. The scene may have been edited and the camera
// was moved by hand: so it has no hash of the scene's content, and is neither resumed nor merged. Albedo
// and normals are those of the pixels' centers.
session::RenderFile RenderFileOf(editor::SavedRender&& render);

}  // namespace raygraph::cli
