// Barycentrics of the center of each drawn pixel, computed as in resolve_visibility.comp. The device's own
// interpolation is inexact over a large triangle or at a grazing angle: it rounds vertices to a grid in the
// picture, and clips behind the camera.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/triangle.glsl"
#include "raster/visibility.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 20, rgba32ui) uniform uimage2D visibility;
layout(push_constant, scalar) uniform Constants { vec2 shift; } constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(visibility);
    if (any(greaterThanEqual(pixel, size))) return;
    Hit hit = UnpackVisibility(imageLoad(visibility, pixel));
    if (hit.t < 0.0f) return;
    CameraRecord camera = parameters.value.camera;
    PictureTriangle triangle = ProjectTriangle(hit.instance, hit.primitive, camera.origin,
                                               OffsetToPicture(camera, constants.shift, uvec2(size)));
    vec3 edges = EdgesAt(triangle, vec2(pixel) + 0.5f);
    // The device's rounding may put the center just outside: use the nearest point inside.
    float sum = edges.x + edges.y + edges.z;
    vec3 weights = max((sum < 0.0f ? -1.0f : 1.0f) * edges, vec3(0.0f));
    sum = weights.x + weights.y + weights.z;
    if (sum > 0.0f)
        imageStore(visibility, pixel, PackVisibility(hit.instance, hit.primitive, weights.yz / sum));
}
