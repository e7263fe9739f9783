// Camera rays.
#ifndef RAYGRAPH_SCENE_CAMERA_GLSL
#define RAYGRAPH_SCENE_CAMERA_GLSL

#include "scene/ray.glsl"
#include "shared/scene_records.h"

// film: (0, 0) is the upper left corner of the picture, (1, 1) the lower right.
Ray CameraRay(CameraRecord camera, vec2 film) {
    vec3 offset = (2.0f * film.x - 1.0f) * camera.right + (1.0f - 2.0f * film.y) * camera.up;
    bool isOrthographic = camera.orthographic != 0u;
    Ray ray;
    ray.origin = isOrthographic ? camera.origin + offset : camera.origin;
    ray.direction = isOrthographic ? camera.forward : normalize(camera.forward + offset);
    return ray;
}

#endif
