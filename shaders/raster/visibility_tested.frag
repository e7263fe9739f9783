// Fragments of alpha-tested triangles.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/fragment_alpha.glsl"
#include "raster/visibility.glsl"

layout(location = 0) in vec2 barycentrics;
layout(location = 1) flat in uvec2 triangle;
layout(location = 0) out uvec4 visibility;

void main() {
    if (!PassesAlphaTest(triangle, barycentrics, !gl_FrontFacing)) discard;
    visibility = PackVisibility(triangle.x, triangle.y, barycentrics);
}
