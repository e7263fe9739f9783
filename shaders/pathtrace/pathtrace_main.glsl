// Ray generation of Trace: one sample of every pixel. Includers may define COUNT_RAYS
// and PATH_PARTS.
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
#ifdef PATH_PARTS
layout(set = 0, binding = 18, rgba32f) writeonly uniform image2D emission;
layout(set = 0, binding = 19, rgba32f) writeonly uniform image2D direct;
layout(set = 0, binding = 20, rgba32f) writeonly uniform image2D indirect;
layout(set = 0, binding = 21, rgba32f) writeonly uniform image2D diffuse;
layout(set = 0, binding = 22, rgba32f) writeonly uniform image2D specular;
layout(set = 0, binding = 23, rgba32f) writeonly uniform image2D transmission;
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
#ifdef PATH_PARTS
    imageStore(emission, ivec2(pixel), vec4(path.parts.emission, path.alpha));
    imageStore(direct, ivec2(pixel), vec4(path.parts.direct, path.alpha));
    imageStore(indirect, ivec2(pixel), vec4(path.parts.indirect, path.alpha));
    imageStore(diffuse, ivec2(pixel), vec4(path.parts.diffuse, path.alpha));
    imageStore(specular, ivec2(pixel), vec4(path.parts.specular, path.alpha));
    imageStore(transmission, ivec2(pixel), vec4(path.parts.transmission, path.alpha));
#endif
}
