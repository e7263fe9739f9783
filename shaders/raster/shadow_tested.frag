// Fragments of ShadowMaps that are there by their alpha; depth alone is written.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/fragment_alpha.glsl"

layout(location = 0) in vec2 barycentrics;
layout(location = 1) flat in uvec2 triangle;

void main() {
    // What is a back to the light is a front to the rays that ask for it
    if (!IsFragmentThere(triangle, barycentrics, gl_FrontFacing)) discard;
}
