// Vertices of ShadowMaps: each instance is a placement in one shadow view, drawn into the view's tile and cut
// off at the tile's sides.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/projection.glsl"
#include "raster/triangle.glsl"
#include "shared/shadow_records.h"

layout(set = 0, binding = 16, scalar) readonly buffer Casters { ShadowCaster at[]; } casters;
layout(set = 0, binding = 17, scalar) readonly buffer ShadowViews { ShadowView at[]; } shadowViews;
layout(push_constant, scalar) uniform Constants { uint tilesPerSide; } constants;

layout(location = 0) out vec2 barycentrics;
layout(location = 1) flat out uvec2 triangle;  // instance record, primitive
out float gl_ClipDistance[4];

void main() {
    ShadowCaster caster = casters.at[gl_InstanceIndex];
    Corner corner = CornerOf(caster.placement, uint(gl_VertexIndex));
    vec4 clip = ClipPosition(shadowViews.at[caster.view].camera, corner.position, vec2(0.0f));
    gl_ClipDistance[0] = clip.w + clip.x;
    gl_ClipDistance[1] = clip.w - clip.x;
    gl_ClipDistance[2] = clip.w + clip.y;
    gl_ClipDistance[3] = clip.w - clip.y;
    float scale = 1.0f / float(constants.tilesPerSide);
    uvec2 tile = uvec2(caster.view % constants.tilesPerSide, caster.view / constants.tilesPerSide);
    vec2 center = scale * (2.0f * vec2(tile) + 1.0f) - 1.0f;
    gl_Position = vec4(clip.xy * scale + center * clip.w, clip.zw);
    barycentrics = corner.barycentrics;
    triangle = uvec2(caster.placement, corner.primitive);
}
