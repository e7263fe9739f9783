// Fragments of opaque triangles.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "raster/visibility.glsl"

layout(location = 0) in vec2 barycentrics;
layout(location = 1) flat in uvec2 triangle;
layout(location = 0) out uvec4 visibility;

void main() { visibility = PackVisibility(triangle.x, triangle.y, barycentrics); }
