// Cameras as the shaders read them. Threads: plain values and pure functions, for any thread.
#pragma once

#include "base/api.h"
#include "renderer/scene/model/camera_view.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

RAYGRAPH_API gpu::CameraRecord ToRecord(const scene::CameraView& view);
// Returns the position of the record's camera in world space.
RAYGRAPH_API glm::dvec3 EyeOf(const gpu::CameraRecord& camera);

}  // namespace raygraph
