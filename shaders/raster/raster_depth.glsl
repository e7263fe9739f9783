// Converts the depth buffer of a raster view to distances, the inverse of raster/projection.glsl, and back.
#ifndef RAYGRAPH_RASTER_RASTER_DEPTH_GLSL
#define RAYGRAPH_RASTER_RASTER_DEPTH_GLSL

#include "scene/ray.glsl"

// Returns meters along the camera's forward. Depth 0 gives infinity or the camera's zFar.
float DistanceOf(CameraRecord camera, float depth) {
    return camera.orthographic != 0u ? (1.0f - depth) * camera.zFar : camera.zNear / depth;
}

// Returns the depth of a distance.
float RasterDepthOf(CameraRecord camera, float distance) {
    return camera.orthographic != 0u ? 1.0f - distance / camera.zFar : camera.zNear / distance;
}

// Returns the point of a pixel's camera ray at the pixel's depth.
vec3 PositionAtRasterDepth(CameraRecord camera, Ray ray, float depth) {
    return ray.origin + ray.direction * (DistanceOf(camera, depth) / dot(ray.direction, camera.forward));
}

#endif
