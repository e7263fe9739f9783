// Fragments of triangles that are there by their alpha: as they are to the camera ray of the same pixel and
// sample.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/visibility.glsl"
#include "scene/alpha_test.glsl"

layout(location = 0) in vec2 barycentrics;
layout(location = 1) flat in uvec2 triangle;
layout(location = 0) out uvec4 visibility;

void main() {
    TraceParameters settings = parameters.value;
    Sampler rng = StartPixelSample(uvec2(gl_FragCoord.xy), settings.sampleIndex, settings.seed);
    if (!IsThere(AlphaSeed(rng, 1u), triangle.x, triangle.y, barycentrics)) discard;
    visibility = PackVisibility(triangle.x, triangle.y, barycentrics);
}
