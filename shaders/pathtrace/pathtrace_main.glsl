// Ray generation of Trace: one sample of every pixel of a region of the picture. Includers may define
// COUNT_RAYS, PATH_PARTS and LIGHT_GROUPS. Images have the region's size; `texel` is a position in them,
// `pixel` one in the picture.
//
// An invocation follows one path after the other, and takes the next pixel as soon as a path ends: paths
// differ in length, and invocations that run in lockstep would wait for the longest. There are at most as
// many invocations as pixels. Which one takes which pixel does not affect the picture.
#define TRACES_SHADOW_RAYS
#include "scene/extensions.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"
#include "scene/trace_rays.glsl"

#ifdef LIGHT_GROUPS
vec3 groupSums[kMaxLightGroups];

// Of a light, and of its triangle if it is a mesh: FirstLightGroup of renderer/gpu_scene/light_groups.h.
uint GroupOf(uint light, uint triangle) {
    LightRecord record = LightAt(light);
    uint group = record.flags >> kLightGroupShift;
    if (!HasTraceFeature(kTraceMeshLights) || record.kind != kLightMesh) return group;
    uint other = LightAt(LightMeshAt(record.primitive).firstLight + triangle).flags >> kLightGroupShift;
    return group == kLightGroupRest || other == kLightGroupRest ? max(group, other) : min(group, other);
}

void AddToGroup(vec3 value, uint light, uint triangle) {
    uint group = kLightGroupRest;
    if (light == LightSet().lightCount)
        group = kLightGroupEnvironment;
    else if (light != kNoLight)
        group = GroupOf(light, triangle);
    groupSums[min(group, kMaxLightGroups - 1u)] += value;
}
#endif

#include "integrator/camera_media.glsl"
#include "integrator/extend_path.glsl"
#include "pathtrace/start.glsl"

layout(set = 0, binding = 16, rgba32f) writeonly uniform image2D radiance;
layout(set = 0, binding = 24, scalar) buffer PixelQueue {  // starts at 0; passes/trace.h: TraceCounts
    uint takenCount;
    uint nonFiniteCount;
} pixelQueue;
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
#ifdef LIGHT_GROUPS
// A tile for each group, row by row; there may be fewer than kMaxLightGroups
layout(set = 0, binding = 25, rgba32f) writeonly uniform image2D lightGroups;
#endif

#ifdef LIGHT_GROUPS
void StoreGroups(ivec2 texel, ivec2 size, float alpha) {
    int columns = imageSize(lightGroups).x / size.x;
    int rows = imageSize(lightGroups).y / size.y;
    for (int i = 0; i < min(columns * rows, int(kMaxLightGroups)); ++i)
        imageStore(lightGroups, ivec2(i % columns, i / columns) * size + texel, vec4(groupSums[i], alpha));
}
#endif

// The next texel that no invocation has taken, in rows from the top. False: there is none.
bool TakeTexel(uvec2 size, out uvec2 texel) {
    uint index = atomicAdd(pixelQueue.takenCount, 1u);
    texel = uvec2(index % size.x, index / size.x);
    return texel.y < size.y;
}

// An infinite or NaN sample is written as black, and counted: later passes need not check.
void BlackenIfNotFinite(inout PathState path) {
    if (IsFinite(path.radiance)) return;
    atomicAdd(pixelQueue.nonFiniteCount, 1u);
    path.radiance = vec3(0.0f);
    if (kKeepsParts) path.parts = NoParts();
#ifdef LIGHT_GROUPS
    for (uint i = 0u; i < kMaxLightGroups; ++i) groupSums[i] = vec3(0.0f);
#endif
}

void Store(uvec2 texel, PathState path) {
    BlackenIfNotFinite(path);
    imageStore(radiance, ivec2(texel), vec4(path.radiance, path.alpha));
#ifdef COUNT_RAYS
    imageStore(rayCounts, ivec2(texel), vec4(float(path.rayCount)));
#endif
#ifdef PATH_PARTS
    imageStore(emission, ivec2(texel), vec4(path.parts.emission, path.alpha));
    imageStore(direct, ivec2(texel), vec4(path.parts.direct, path.alpha));
    imageStore(indirect, ivec2(texel), vec4(path.parts.indirect, path.alpha));
    imageStore(diffuse, ivec2(texel), vec4(path.parts.diffuse, path.alpha));
    imageStore(specular, ivec2(texel), vec4(path.parts.specular, path.alpha));
    imageStore(transmission, ivec2(texel), vec4(path.parts.transmission, path.alpha));
#endif
#ifdef LIGHT_GROUPS
    StoreGroups(ivec2(texel), imageSize(radiance), path.alpha);
#endif
}

void main() {
    uvec2 size = uvec2(imageSize(radiance));
    PathSettings settings = SettingsOf(parameters.value);
    uvec2 texel;
    PathState path;
    bool isGoingOn = false;
    bool isProbed = false;
    vec3 probedOrigin = vec3(0.0f);
    MediumStack cameraMedia = NoMedia();
    while (true) {
        if (!isGoingOn) {
            if (!TakeTexel(size, texel)) return;
            path = PathOf(texel);
#ifdef LIGHT_GROUPS
            for (uint i = 0u; i < kMaxLightGroups; ++i) groupSums[i] = vec3(0.0f);
#endif
            if (HasTraceFeature(kTraceProbeMedia)) {
                // Of a pinhole camera, all rays start at one point
                if (!isProbed || path.ray.origin != probedOrigin) cameraMedia = MediaAround(path.ray.origin);
                isProbed = true;
                probedOrigin = path.ray.origin;
                path.media = cameraMedia;
            }
        }
        isGoingOn = ExtendPath(path, settings);
        if (!isGoingOn) Store(texel, path);
    }
}
