// The start of a path at the camera, for every form of the integrator. Includers declare the scene and
// integrator/path.glsl beforehand.
#ifndef RAYGRAPH_PATHTRACE_START_GLSL
#define RAYGRAPH_PATHTRACE_START_GLSL

#include "scene/pixel_list.glsl"

SHADING_BEGIN

INLINE PathSettings SettingsOf(TraceParameters from) {
    PathSettings settings;
    settings.maxDepth = from.maxDepth;
    settings.rouletteStart = from.rouletteStart;
    settings.survival = from.survival;
    settings.frameDepth = from.frameDepth;
    settings.clampIndirect = from.clampIndirect;
    settings.regularize = from.regularize;
    return settings;
}

INLINE uint ListIndexOf(uvec2 texel) {
    return texel.y % parameters.value.sampleRows * parameters.value.pixelListWidth + texel.x;
}
INLINE ListedPixel ListedAt(uvec2 texel) {
    return PixelListStream(parameters.value.pixelList).at[ListIndexOf(texel)];
}

// Returns whether a texel fills up the rows of a list, and is of no pixel: it is not traced.
INLINE bool IsPastListEnd(uvec2 texel) {
    return HasTraceFeature(kTracePixelList) && ListIndexOf(texel) >= parameters.value.pixelListCount;
}

// Returns the pixel of the picture that a texel of the outputs is of: they hold one sample below the other.
INLINE uvec2 PixelOf(uvec2 texel) {
    uvec2 inRegion = uvec2(texel.x, texel.y % parameters.value.sampleRows);
    if (HasTraceFeature(kTracePixelList)) inRegion = PixelOf(ListedAt(texel));
    return inRegion + parameters.value.regionOffset;
}

// Returns the random numbers of a texel.
INLINE Sampler RngOf(uvec2 texel) {
    uint sampleIndex = parameters.value.sampleIndex + texel.y / parameters.value.sampleRows;
    if (HasTraceFeature(kTracePixelList)) sampleIndex += ListedAt(texel).sampleIndex;
    return StartPixelSample(PixelOf(texel), sampleIndex, parameters.value.seed);
}

INLINE PathState PathOf(uvec2 texel) {
    Sampler rng = RngOf(texel);
    vec2 film = (vec2(PixelOf(texel)) + Get2D(rng)) / vec2(parameters.value.pictureSize);
    Ray ray = CameraRay(parameters.value.camera, film, Get2D(rng));
    if (HasTraceFeature(kTraceTextureLod))
        ray.cone = PixelCone(parameters.value.camera, parameters.value.pictureSize, ray.direction);
    return StartPath(ray, rng);
}

SHADING_END

#endif
