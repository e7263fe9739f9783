// Finds the present place on the picture of the surface that each pixel saw, after the scene and the camera
// have moved.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/projection.glsl"
#include "raster/visibility.glsl"
#include "scene/camera.glsl"
#include "scene/hit_position.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 20, rgba32ui) readonly uniform uimage2D visibility;
layout(set = 0, binding = 21, rgba32f) writeonly uniform image2D places;
layout(set = 0, binding = 22, scalar) uniform SeenBy { CameraRecord camera; } seenBy;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(visibility)))) return;
    uvec2 pixel = uvec2(texel) + parameters.value.regionOffset;
    uvec2 size = parameters.value.pictureSize;
    CameraRecord camera = parameters.value.camera;
    Hit hit = UnpackVisibility(imageLoad(visibility, texel));
    vec3 offset;
    if (IsHit(hit)) {
        InstanceRecord instance = instances.at[hit.instance];
        offset = instance.objectToWorld * vec4(ObjectPositionOf(instance, hit), 1.0f) - camera.origin;
    } else  // infinitely far away: only its direction counts
        offset = CameraRay(seenBy.camera, (vec2(pixel) + 0.5f) / vec2(size), vec2(0.5f)).direction;
    vec4 clip = OffsetToClip(camera, vec2(0.0f)) * vec4(offset, 1.0f);
    // A hit that is hidden now has no place either: its vertices may be those of another time.
    bool isHidden = IsHit(hit) && instances.at[hit.instance].draw == kNotDrawn;
    float placeless = clip.w > 0.0f && !isHidden ? 0.0f : 1.0f;
    vec2 place = (0.5f * clip.xy / clip.w + 0.5f) * vec2(size);
    if (!IsHit(hit) && camera.orthographic != 0u) place = vec2(pixel) + 0.5f;  // all see the same direction
    imageStore(places, texel, vec4(place, placeless, 0.0f));
}
