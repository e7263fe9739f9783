// Ray generation of Trace: one sample of every pixel. Includers may define COUNT_RAYS.
#define TRACES_SHADOW_RAYS
#include "scene/extensions.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"
#include "scene/trace_rays.glsl"

#include "integrator/camera_media.glsl"
#include "integrator/path.glsl"

layout(set = 0, binding = 16, rgba32f) writeonly uniform image2D radiance;
#ifdef COUNT_RAYS
layout(set = 0, binding = 17, r32f) writeonly uniform image2D rayCounts;
#endif

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

void main() {
    uvec2 pixel = gl_LaunchIDEXT.xy;
    Sampler rng = StartPixelSample(pixel, parameters.value.sampleIndex, parameters.value.seed);
    vec2 film = (vec2(pixel) + Get2D(rng)) / vec2(gl_LaunchSizeEXT.xy);
    PathSettings settings = SettingsOf(parameters.value);
    PathState path = StartPath(CameraRay(parameters.value.camera, film, Get2D(rng)), rng);
    if (HasTraceFeature(kTraceProbeMedia)) path.media = MediaAround(path.ray.origin);
    while (ExtendPath(path, settings)) {
    }
    imageStore(radiance, ivec2(pixel), vec4(path.radiance, path.alpha));
#ifdef COUNT_RAYS
    imageStore(rayCounts, ivec2(pixel), vec4(float(path.rayCount)));
#endif
}
