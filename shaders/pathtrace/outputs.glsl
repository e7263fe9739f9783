// The outputs of Trace (passes/trace.h): the radiance, its parts if PATH_PARTS is defined, the light groups
// if LIGHT_GROUPS is, and rays and bounces if COUNT_RAYS is. Images have the region's size; a texel is a
// position in them. Includers that add to what is there define OUTPUTS_ARE_READ.
#ifndef RAYGRAPH_PATHTRACE_OUTPUTS_GLSL
#define RAYGRAPH_PATHTRACE_OUTPUTS_GLSL

#include "pathtrace/light_groups.glsl"

#include "integrator/path_state.glsl"
#include "integrator/shadow_catcher.glsl"

#ifdef OUTPUTS_ARE_READ
#define OUTPUT_ACCESS
#else
#define OUTPUT_ACCESS writeonly
#endif

layout(set = 0, binding = 16, rgba32f) OUTPUT_ACCESS uniform image2D radiance;
#ifdef COUNT_RAYS
layout(set = 0, binding = 17, r32f) writeonly uniform image2D rayCounts;
layout(set = 0, binding = 18, r32f) writeonly uniform image2D bounceCounts;
#endif
#ifdef PATH_PARTS
layout(set = 0, binding = 18, rgba32f) OUTPUT_ACCESS uniform image2D emission;
layout(set = 0, binding = 19, rgba32f) OUTPUT_ACCESS uniform image2D direct;
layout(set = 0, binding = 20, rgba32f) OUTPUT_ACCESS uniform image2D indirect;
layout(set = 0, binding = 21, rgba32f) OUTPUT_ACCESS uniform image2D diffuse;
layout(set = 0, binding = 22, rgba32f) OUTPUT_ACCESS uniform image2D specular;
layout(set = 0, binding = 23, rgba32f) OUTPUT_ACCESS uniform image2D transmission;
#endif
layout(set = 0, binding = 24, scalar) buffer PixelQueue {  // starts at 0; passes/trace.h: TraceCounts
    uint acquiredCount;
    uint nonFiniteCount;
    uint rayCount[2];  // rays of all paths: the low word and the high one
} pixelQueue;

// Adds to the number of traced rays: those of one path of the invocation, or of several.
void CountRays(uint count) {
    if (count == 0u) return;
    uint before = atomicAdd(pixelQueue.rayCount[0], count);
    if (before + count < before) atomicAdd(pixelQueue.rayCount[1], 1u);
}
#ifdef LIGHT_GROUPS
// Each group has a tile, row by row; there may be fewer than kMaxLightGroups
layout(set = 0, binding = 25, rgba32f) OUTPUT_ACCESS uniform image2D lightGroups;

int GroupCount(ivec2 size) {
    ivec2 tiles = imageSize(lightGroups) / size;
    return min(tiles.x * tiles.y, int(kMaxLightGroups));
}

ivec2 GroupTexel(int group, ivec2 texel, ivec2 size) {
    int columns = imageSize(lightGroups).x / size.x;
    return ivec2(group % columns, group / columns) * size + texel;
}
#endif

// Makes the sample of a path that has ended. An infinite or NaN one is written as black, and counted: later
// passes need not check.
void FinishSample(inout PathState path) {
    if (!IsFinite(path.radiance)) {
        atomicAdd(pixelQueue.nonFiniteCount, 1u);
        path.radiance = vec3(0.0f);
        if (kKeepsParts) path.parts = NoParts();
        ClearGroups();
    }
    if (IsCaught(path)) {
        FinishCaught(path);
        ClearGroups();
    }
}

void StoreOutputs(ivec2 texel, PathState path) {
    imageStore(radiance, texel, vec4(path.radiance, path.alpha));
#ifdef COUNT_RAYS
    imageStore(rayCounts, texel, vec4(float(path.rayCount)));
    imageStore(bounceCounts, texel, vec4(float(path.depth)));
#endif
#ifdef PATH_PARTS
    imageStore(emission, texel, vec4(path.parts.emission, path.alpha));
    imageStore(direct, texel, vec4(path.parts.direct, path.alpha));
    imageStore(indirect, texel, vec4(path.parts.indirect, path.alpha));
    imageStore(diffuse, texel, vec4(path.parts.diffuse, path.alpha));
    imageStore(specular, texel, vec4(path.parts.specular, path.alpha));
    imageStore(transmission, texel, vec4(path.parts.transmission, path.alpha));
#endif
#ifdef LIGHT_GROUPS
    ivec2 size = imageSize(radiance);
    for (int i = 0; i < GroupCount(size); ++i)
        imageStore(lightGroups, GroupTexel(i, texel, size), vec4(groupSums[i], path.alpha));
#endif
}

#ifdef OUTPUTS_ARE_READ
// Loads the stored sums of the texel into the path.
void LoadOutputs(ivec2 texel, inout PathState path) {
    vec4 stored = imageLoad(radiance, texel);
    path.radiance = stored.xyz;
    path.alpha = stored.w;
#ifdef PATH_PARTS
    path.parts.emission = imageLoad(emission, texel).xyz;
    path.parts.direct = imageLoad(direct, texel).xyz;
    path.parts.indirect = imageLoad(indirect, texel).xyz;
    path.parts.diffuse = imageLoad(diffuse, texel).xyz;
    path.parts.specular = imageLoad(specular, texel).xyz;
    path.parts.transmission = imageLoad(transmission, texel).xyz;
#endif
#ifdef LIGHT_GROUPS
    ivec2 size = imageSize(radiance);
    for (int i = 0; i < GroupCount(size); ++i)
        groupSums[i] = imageLoad(lightGroups, GroupTexel(i, texel, size)).xyz;
#endif
}
#endif

#endif
