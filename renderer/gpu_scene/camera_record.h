// Cameras as the shaders want them. Threads: plain values and pure functions, for any thread.
#pragma once

#include "base/api.h"
#include "renderer/scene/camera_view.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

RAYGRAPH_API gpu::CameraRecord ToRecord(const scene::CameraView& view);
// Where the record's camera is, in the world.
RAYGRAPH_API glm::dvec3 EyeOf(const gpu::CameraRecord& camera);

}  // namespace raygraph
