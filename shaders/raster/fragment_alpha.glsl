// Fragments of alpha-tested triangles.
#ifndef RAYGRAPH_RASTER_FRAGMENT_ALPHA_GLSL
#define RAYGRAPH_RASTER_FRAGMENT_ALPHA_GLSL

#include "scene/alpha_test.glsl"

// Returns the decision of the camera ray of the same pixel and sample.
bool PassesAlphaTest(uvec2 triangle, vec2 barycentrics, bool isBack) {
    TraceParameters settings = parameters.value;
    Sampler rng = StartPixelSample(uvec2(gl_FragCoord.xy), settings.sampleIndex, settings.seed);
    return StopsRay(AlphaSeed(rng, 1u), triangle.x, triangle.y, barycentrics, isBack);
}

#endif
