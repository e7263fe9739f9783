// How the camera starts a path, for every form of the integrator. Includers declare the scene and
// integrator/path.glsl beforehand.
#ifndef RAYGRAPH_PATHTRACE_START_GLSL
#define RAYGRAPH_PATHTRACE_START_GLSL

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

// The random numbers of a texel of the traced region.
Sampler RngOf(uvec2 texel) {
    uvec2 pixel = texel + parameters.value.regionOffset;
    return StartPixelSample(pixel, parameters.value.sampleIndex, parameters.value.seed);
}

PathState PathOf(uvec2 texel) {
    uvec2 pixel = texel + parameters.value.regionOffset;
    Sampler rng = RngOf(texel);
    vec2 film = (vec2(pixel) + Get2D(rng)) / vec2(parameters.value.pictureSize);
    Ray ray = CameraRay(parameters.value.camera, film, Get2D(rng));
    if (HasTraceFeature(kTraceTextureLod))
        ray.cone = PixelCone(parameters.value.camera, parameters.value.pictureSize, ray.direction);
    return StartPath(ray, rng);
}

#endif
