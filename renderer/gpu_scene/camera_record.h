// Cameras as the shaders want them.
#pragma once

#include "renderer/scene/camera_view.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

gpu::CameraRecord ToRecord(const scene::CameraView& view);

}  // namespace raygraph
