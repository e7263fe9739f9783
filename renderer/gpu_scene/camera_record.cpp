#include "renderer/gpu_scene/camera_record.h"

#include <cmath>

namespace raygraph {

namespace {

constexpr float kDefaultZFar = 1e4f;  // metres

}  // namespace

gpu::CameraRecord ToRecord(const scene::CameraView& view) {
    const bool isOrthographic = view.projection == scene::Projection::Orthographic;
    const float halfHeight = isOrthographic ? 0.5f * view.height : std::tan(0.5f * view.yFov);
    return {
        .origin = view.eye,
        .orthographic = isOrthographic ? 1u : 0u,
        .right = halfHeight * view.aspect * view.right,
        .up = halfHeight * view.up,
        .forward = view.forward,
        .lensRadius = 0.0f,
        .focusDistance = 1.0f,
        .zNear = view.zNear,
        .zFar = view.zFar > 0.0f ? view.zFar : kDefaultZFar,
    };
}

}  // namespace raygraph
