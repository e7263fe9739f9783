#include "renderer/gpu_scene/camera_record.h"

#include <cmath>

#include "renderer/scene/geometry/transforms.h"

namespace raygraph {

namespace {

constexpr float kDefaultZFar = 1e4f;  // in meters

}  // namespace

gpu::CameraRecord ToRecord(const scene::CameraView& view) {
    const bool isOrthographic = view.projection == scene::Projection::Orthographic;
    const float halfHeight = isOrthographic ? 0.5f * view.height : std::tan(0.5f * view.yFov);
    const scene::FloatPair eye = scene::ToFloatPair(view.eye);
    return {
        .origin = eye.rounded,
        .orthographic = isOrthographic ? 1u : 0u,
        .right = halfHeight * view.aspect * view.right,
        .up = halfHeight * view.up,
        .forward = view.forward,
        .lensRadius = 0.0f,
        .focusDistance = 1.0f,
        .zNear = view.zNear,
        .zFar = view.zFar > 0.0f ? view.zFar : kDefaultZFar,
        .originResidual = eye.rest,
    };
}

glm::dvec3 EyeOf(const gpu::CameraRecord& camera) {
    return glm::dvec3(camera.origin) + glm::dvec3(camera.originResidual);
}

}  // namespace raygraph
