// Normal maps of two channels. Internal to renderer/scene.
#pragma once

#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Gives normal maps that are stored as x and y alone (BC5, red and green of KTX2), whose blue is 0 in all
// texels, the third channel: z of a unit vector that points up. Their blocks go, but those of BC5, to which
// shaders give it. Images that are used for anything else too stay as they are. Threads: exclusive access to
// the scene.
void CompleteNormalMaps(SceneData& scene);

}  // namespace raygraph::scene
