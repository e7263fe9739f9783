// Ray generation of Trace: one sample of every pixel. Includers may define COUNT_RAYS.
#include "scene/extensions.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/surface.glsl"
#include "scene/trace_rays.glsl"

#include "integrator/path.glsl"

layout(set = 0, binding = 6, rgba32f) writeonly uniform image2D radiance;
#ifdef COUNT_RAYS
layout(set = 0, binding = 7, r32f) writeonly uniform image2D rayCounts;
#endif

PathState StartPixel(uvec2 pixel, uvec2 size) {
    Sampler rng = StartPixelSample(pixel, parameters.value.sampleIndex, parameters.value.seed);
    vec2 film = (vec2(pixel) + Get2D(rng)) / vec2(size);
    return StartPath(CameraRay(parameters.value.camera, film), rng);
}

void StorePixel(uvec2 pixel, PathState path) {
    imageStore(radiance, ivec2(pixel), vec4(path.radiance, path.alpha));
#ifdef COUNT_RAYS
    imageStore(rayCounts, ivec2(pixel), vec4(float(path.depth + 1u)));
#endif
}

void main() {
    PathSettings settings;
    settings.maxDepth = parameters.value.maxDepth;
    settings.rouletteStart = parameters.value.rouletteStart;
    uvec2 size = uvec2(imageSize(radiance));
    uint rows = parameters.value.pixelsPerInvocation;
    uvec2 pixel = uvec2(gl_LaunchIDEXT.x, gl_LaunchIDEXT.y * rows);
    uint endRow = min(pixel.y + rows, size.y);
    PathState path = StartPixel(pixel, size);
    while (true) {
        if (ExtendPath(path, settings)) continue;
        StorePixel(pixel, path);
        if (++pixel.y >= endRow) break;
        path = StartPixel(pixel, size);
    }
}
