// The projection of raster views: the inverse of scene/camera.glsl, for a camera without lens.
#ifndef RAYGRAPH_RASTER_PROJECTION_GLSL
#define RAYGRAPH_RASTER_PROJECTION_GLSL

#include "shared/scene_records.h"

// Clip space, depth reversed: 1 at zNear and 0 at infinity (perspective), 1 at the film and 0 at zFar
// (orthographic). `shift` moves the picture, in clip units: (2, 2) is its whole size. From a place relative
// to camera.origin.
mat4 OffsetToClip(CameraRecord camera, vec2 shift) {
    // `precise`: pipelines that draw parts of one surface agree to the bit
    // offset = x right + y up + depth forward, by Cramer's rule: the three need not be orthogonal
    precise vec3 film = cross(camera.right, camera.up);
    precise float scale = 1.0f / dot(film, camera.forward);
    precise vec3 x = scale * cross(camera.up, camera.forward);
    precise vec3 y = -scale * cross(camera.forward, camera.right);  // rows run downwards
    precise vec3 depth = scale * film;
    precise mat4 rows;
    if (camera.orthographic != 0u)
        rows = mat4(vec4(x, shift.x), vec4(y, shift.y), vec4(-depth / camera.zFar, 1.0f),
                    vec4(0.0f, 0.0f, 0.0f, 1.0f));
    else
        rows = mat4(vec4(x + shift.x * depth, 0.0f), vec4(y + shift.y * depth, 0.0f),
                    vec4(0.0f, 0.0f, 0.0f, camera.zNear), vec4(depth, 0.0f));
    return transpose(rows);
}

vec4 ClipPosition(CameraRecord camera, vec3 position, vec2 shift) {
    return OffsetToClip(camera, shift) * vec4(position - camera.origin, 1.0f);
}

// Returns false if the whole box is beyond one side of the picture, or behind the camera.
bool IntersectsFrustum(CameraRecord camera, mat4x3 objectToWorld, vec3 low, vec3 high, vec2 shift) {
    uint outsideOfAll = 0x3Fu;
    for (uint corner = 0u; corner < 8u; ++corner) {
        vec3 at = vec3((corner & 1u) != 0u ? high.x : low.x, (corner & 2u) != 0u ? high.y : low.y,
                       (corner & 4u) != 0u ? high.z : low.z);
        vec4 clip = ClipPosition(camera, objectToWorld * vec4(at, 1.0f), shift);
        uint outside = 0u;
        if (clip.x < -clip.w) outside |= 1u;
        if (clip.x > clip.w) outside |= 2u;
        if (clip.y < -clip.w) outside |= 4u;
        if (clip.y > clip.w) outside |= 8u;
        if (clip.z > clip.w) outside |= 16u;  // nearer than zNear, or behind
        if (clip.z < 0.0f) outside |= 32u;
        outsideOfAll &= outside;
    }
    return outsideOfAll == 0u;
}

#endif
