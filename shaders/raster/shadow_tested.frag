// Alpha-tested fragments of ShadowMaps; only depth is written.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/fragment_alpha.glsl"

layout(location = 0) in vec2 barycentrics;
layout(location = 1) flat in uvec2 triangle;

void main() {
    // A back face towards the light is a front face to shadow rays
    if (!PassesAlphaTest(triangle, barycentrics, gl_FrontFacing)) discard;
}
