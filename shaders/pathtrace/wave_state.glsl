// What the kernels of a wavefront hand on (passes/wavefront.cpp): the state of the paths, the hits of their rays, and
// their shadow rays. A path keeps one slot, its texel's number, as long as it lives; the queues name those
// that do. Records are rows of 16 bytes, one after the other.
#ifndef RAYGRAPH_PATHTRACE_WAVE_STATE_GLSL
#define RAYGRAPH_PATHTRACE_WAVE_STATE_GLSL

#include "shared/wavefront.h"

layout(set = 0, binding = 16, rgba32f) uniform image2D radiance;
layout(set = 0, binding = 17, std430) buffer WavePaths { vec4 at[]; } wavePaths;
layout(set = 0, binding = 18, std430) buffer WaveHits { uvec4 at[]; } waveHits;
layout(set = 0, binding = 19, std430) buffer WaveShadows { vec4 at[]; } waveShadows;
layout(set = 0, binding = 20, std430) buffer WaveQueue { uint at[]; } waveQueue;  // one after the other: a half for each parity
layout(set = 0, binding = 21, std430) buffer WaveCounts { uint at[]; } waveCounts;
layout(set = 0, binding = 22, std430) buffer WaveMedia { vec4 at[]; } waveMedia;
layout(set = 0, binding = 24, scalar) buffer PixelQueue {  // starts at 0; passes/trace.h: TraceCounts
    uint takenCount;
    uint nonFiniteCount;
} pixelQueue;
layout(push_constant) uniform Wave {
    uint step;       // rays that the paths have traced before this one
    uint pixelCount;
    uint width;      // of the traced region
    uint isProbedOnce;  // the media of all camera rays are those of the first
} wave;

ivec2 TexelOf(uint slot) { return ivec2(slot % wave.width, slot / wave.width); }

uint LiveCount() { return wave.step == 0u ? wave.pixelCount : waveCounts.at[2u * wave.step]; }
uint SlotAt(uint i) {
    return wave.step == 0u ? i : waveQueue.at[(wave.step & 1u) * wave.pixelCount + i];
}
uint ShadowCount() { return waveCounts.at[2u * wave.step + 1u]; }

#ifdef WAVE_QUEUES
// A place of its own in a queue for each invocation that wants one; one atomic operation a subgroup.
uint TakePlace(uint counter, bool wants) {
    uvec4 votes = subgroupBallot(wants);
    uint first = 0u;
    if (subgroupElect()) first = atomicAdd(waveCounts.at[counter], subgroupBallotBitCount(votes));
    return subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(votes);
}

void Enqueue(uint slot, bool wants) {
    uint at = TakePlace(2u * wave.step + 2u, wants);
    if (wants) waveQueue.at[((wave.step + 1u) & 1u) * wave.pixelCount + at] = slot;
}
#endif

// ---------------------------------------------------------------------------------------------------- paths

void StorePath(uint slot, PathState path) {
    uint row = kWavePathRows * slot;
    wavePaths.at[row] = vec4(path.ray.origin, uintBitsToFloat(path.rayCount));
    wavePaths.at[row + 1u] = vec4(path.ray.direction, path.scatterPDF);
    wavePaths.at[row + 2u] = vec4(path.throughput, path.etaScale);
    uint packed = path.depth | (path.alpha > 0.0f ? 0x80000000u : 0u);
    wavePaths.at[row + 3u] = vec4(path.scatter.position, uintBitsToFloat(packed));
    wavePaths.at[row + 4u] = vec4(path.scatter.normal, path.wavelength);
    if (HasTraceFeature(kTraceVolumes)) {
        waveMedia.at[2u * slot] = vec4(path.start.normal, path.start.height);
        waveMedia.at[2u * slot + 1u] = uintBitsToFloat(uvec4(path.media.m0, path.media.m1, path.media.m2, path.media.m3));
    }
}

// Where the media around the origin of a camera ray are: behind those of all paths if they are the same.
uint CameraMediaOf(uint slot) { return wave.isProbedOnce != 0u ? wave.pixelCount : slot; }

void StoreMedia(uint slot, MediumStack media) {
    waveMedia.at[2u * slot + 1u] = uintBitsToFloat(uvec4(media.m0, media.m1, media.m2, media.m3));
}

MediumStack LoadMedia(uint slot) {
    uvec4 read = floatBitsToUint(waveMedia.at[2u * slot + 1u]);
    MediumStack media;
    media.m0 = read.x;
    media.m1 = read.y;
    media.m2 = read.z;
    media.m3 = read.w;
    return media;
}

Ray LoadRay(uint slot, out uint rayCount) {
    vec4 first = wavePaths.at[kWavePathRows * slot];
    Ray ray;
    ray.origin = first.xyz;
    rayCount = floatBitsToUint(first.w);
    ray.direction = wavePaths.at[kWavePathRows * slot + 1u].xyz;
    ray.cone = MakeCone(0.0f, 0.0f);
    return ray;
}

PathState LoadPath(uint slot) {
    uint row = kWavePathRows * slot;
    vec4 first = wavePaths.at[row];
    vec4 second = wavePaths.at[row + 1u];
    vec4 third = wavePaths.at[row + 2u];
    vec4 fourth = wavePaths.at[row + 3u];
    vec4 fifth = wavePaths.at[row + 4u];
    Ray ray;
    ray.origin = first.xyz;
    ray.direction = second.xyz;
    ray.cone = MakeCone(0.0f, 0.0f);
    PathState path = StartPath(ray, RngOf(uvec2(TexelOf(slot))));
    path.rayCount = floatBitsToUint(first.w);
    path.scatterPDF = second.w;
    path.throughput = third.xyz;
    path.etaScale = third.w;
    path.scatter.position = fourth.xyz;
    uint packed = floatBitsToUint(fourth.w);
    path.depth = packed & 0x7fffffffu;
    path.alpha = (packed & 0x80000000u) != 0u ? 1.0f : 0.0f;
    path.scatter.normal = fifth.xyz;
    path.wavelength = fifth.w;
    if (HasTraceFeature(kTraceVolumes)) {
        vec4 start = waveMedia.at[2u * slot];
        path.start.normal = start.xyz;
        path.start.height = start.w;
        path.media = LoadMedia(slot);
    }
    return path;
}

// ----------------------------------------------------------------------------------------------------- hits

void StoreHit(uint slot, Hit hit) {
    waveHits.at[slot] = uvec4(hit.instance, hit.primitive, floatBitsToUint(hit.barycentrics));
    waveHits.at[wave.pixelCount + slot / 4u][slot % 4u] = floatBitsToUint(hit.t);
}

Hit LoadHit(uint slot) {
    uvec4 read = waveHits.at[slot];
    Hit hit;
    hit.instance = read.x;
    hit.primitive = read.y;
    hit.barycentrics = uintBitsToFloat(read.zw);
    hit.t = uintBitsToFloat(waveHits.at[wave.pixelCount + slot / 4u][slot % 4u]);
    return hit;
}

// ---------------------------------------------------------------------------------------------- shadow rays

// `alphaSeed` of its any-hit shaders; `depth` at which it adds light.
void StoreShadow(uint at, uint slot, DirectLight direct, uint alphaSeed, uint depth) {
    uint row = kWaveShadowRows * at;
    waveShadows.at[row] = vec4(direct.ray.origin, direct.distance);
    waveShadows.at[row + 1u] = vec4(direct.ray.direction, direct.ior);
    waveShadows.at[row + 2u] = vec4(direct.radiance, uintBitsToFloat(slot));
    waveShadows.at[row + 3u] = uintBitsToFloat(uvec4(alphaSeed, depth, direct.light, direct.triangle));
}

DirectLight LoadShadow(uint at, out uint slot, out uint alphaSeed, out uint depth) {
    uint row = kWaveShadowRows * at;
    vec4 first = waveShadows.at[row];
    vec4 second = waveShadows.at[row + 1u];
    vec4 third = waveShadows.at[row + 2u];
    uvec4 fourth = floatBitsToUint(waveShadows.at[row + 3u]);
    DirectLight direct = NoDirectLight();
    direct.ray.origin = first.xyz;
    direct.distance = first.w;
    direct.ray.direction = second.xyz;
    direct.ior = second.w;
    direct.radiance = third.xyz;
    slot = floatBitsToUint(third.w);
    alphaSeed = fourth.x;
    depth = fourth.y;
    direct.light = fourth.z;
    direct.triangle = fourth.w;
    return direct;
}

#endif
