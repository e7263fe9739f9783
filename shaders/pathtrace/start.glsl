// How the camera starts a path, for every form of the integrator. Includers declare the scene and
// integrator/path.glsl beforehand.
#ifndef RAYGRAPH_PATHTRACE_START_GLSL
#define RAYGRAPH_PATHTRACE_START_GLSL

#include "shared/listed_pixel.h"

PathSettings SettingsOf(TraceParameters from) {
    PathSettings settings;
    settings.maxDepth = from.maxDepth;
    settings.rouletteStart = from.rouletteStart;
    settings.survival = from.survival;
    settings.frameDepth = from.frameDepth;
    settings.clampIndirect = from.clampIndirect;
    settings.regularize = from.regularize;
    return settings;
}

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PixelListStream {
    ListedPixel at[];
};

ListedPixel ListedAt(uvec2 texel) {
    uint row = texel.y % parameters.value.sampleRows;
    return PixelListStream(parameters.value.pixelList).at[row * parameters.value.pixelListWidth + texel.x];
}

// The pixel of the picture that a texel of the outputs is of: they hold one sample below the other.
uvec2 PixelOf(uvec2 texel) {
    uvec2 inRegion = uvec2(texel.x, texel.y % parameters.value.sampleRows);
    if (HasTraceFeature(kTracePixelList)) {
        uint listed = ListedAt(texel).texel;
        inRegion = uvec2(listed & 0xFFFFu, listed >> 16u);
    }
    return inRegion + parameters.value.regionOffset;
}

// The random numbers of a texel.
Sampler RngOf(uvec2 texel) {
    uint sampleIndex = parameters.value.sampleIndex + texel.y / parameters.value.sampleRows;
    if (HasTraceFeature(kTracePixelList)) sampleIndex += ListedAt(texel).sampleIndex;
    return StartPixelSample(PixelOf(texel), sampleIndex, parameters.value.seed);
}

PathState PathOf(uvec2 texel) {
    Sampler rng = RngOf(texel);
    vec2 film = (vec2(PixelOf(texel)) + Get2D(rng)) / vec2(parameters.value.pictureSize);
    Ray ray = CameraRay(parameters.value.camera, film, Get2D(rng));
    if (HasTraceFeature(kTraceTextureLod))
        ray.cone = PixelCone(parameters.value.camera, parameters.value.pictureSize, ray.direction);
    return StartPath(ray, rng);
}

#endif
