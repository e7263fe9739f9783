// Camera rays.
#ifndef RAYGRAPH_SCENE_CAMERA_GLSL
#define RAYGRAPH_SCENE_CAMERA_GLSL

#include "core/warp.glsl"
#include "scene/ray.glsl"
#include "shared/scene_records.h"

SHADING_BEGIN

// film: (0, 0) is the upper left corner of the picture, (1, 1) the lower right. lens: uniform in the unit
// square, a point of the thin lens; ignored without a lens. Kolb, Mitchell and Hanrahan 1995, "A Realistic
// Camera Model for Computer Graphics", section 2.
INLINE Ray CameraRay(CameraRecord camera, vec2 film, vec2 lens) {
    vec3 offset = (2.0f * film.x - 1.0f) * camera.right + (1.0f - 2.0f * film.y) * camera.up;
    Ray ray;
    ray.cone = MakeCone(0.0f, 0.0f);
    if (camera.orthographic != 0u) {
        ray.origin = camera.origin + offset;
        ray.direction = camera.forward;
        return ray;
    }
    vec3 toFilm = camera.forward + offset;  // 1 along forward
    ray.origin = camera.origin;
    if (camera.lensRadius > 0.0f) {
        vec2 disk = camera.lensRadius * SampleUniformDiskConcentric(lens);
        vec3 onLens = disk.x * normalize(camera.right) + disk.y * normalize(camera.up);
        ray.origin += onLens;
        toFilm = camera.focusDistance * toFilm - onLens;
    }
    ray.direction = normalize(toFilm);
    return ray;
}

// Returns the cone of a pixel of a picture of that size, in a camera ray's direction. A lens does not widen
// it: each of its points sees the scene through a cone of its own.
INLINE RayCone PixelCone(CameraRecord camera, uvec2 pictureSize, vec3 direction) {
    float film = 4.0f * length(camera.right) * length(camera.up);
    float width = sqrt(film / (float(pictureSize.x) * float(pictureSize.y)));
    if (camera.orthographic != 0u) return MakeCone(width, 0.0f);
    return PerspectiveCone(width, max(dot(direction, camera.forward), 0.0f));
}

SHADING_END

#endif
