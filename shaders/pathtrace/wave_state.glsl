// What the kernels of a wavefront hand on (passes/wavefront.cpp): the state of the paths, the hits of their
// rays, their shadow rays, and the queues. A path keeps one slot, its texel's number, as long as it lives;
// the queues name the slots of those that do. Records are rows of 16 bytes, one after the other, so that a
// path is read by few transactions wherever its slot is.
//
// Includers define WAVE_WRITES_PATHS, WAVE_WRITES_HITS, WAVE_WRITES_SHADOWS and WAVE_WRITES_QUEUES for what
// they write.
#ifndef RAYGRAPH_PATHTRACE_WAVE_STATE_GLSL
#define RAYGRAPH_PATHTRACE_WAVE_STATE_GLSL

#include "integrator/path.glsl"
#include "pathtrace/start.glsl"
#include "shared/wavefront.h"

#ifdef WAVE_WRITES_PATHS
#define WAVE_PATHS_ACCESS
#else
#define WAVE_PATHS_ACCESS readonly
#endif
#ifdef WAVE_WRITES_HITS
#define WAVE_HITS_ACCESS
#else
#define WAVE_HITS_ACCESS readonly
#endif
#ifdef WAVE_WRITES_SHADOWS
#define WAVE_SHADOWS_ACCESS
#else
#define WAVE_SHADOWS_ACCESS readonly
#endif
#ifdef WAVE_WRITES_QUEUES
#define WAVE_QUEUES_ACCESS
#else
#define WAVE_QUEUES_ACCESS readonly
#endif

layout(set = 0, binding = 26, std430) WAVE_PATHS_ACCESS buffer WavePaths { vec4 at[]; } wavePaths;
layout(set = 0, binding = 27, std430) WAVE_HITS_ACCESS buffer WaveHits { uvec4 at[]; } waveHits;
layout(set = 0, binding = 28, std430) WAVE_SHADOWS_ACCESS buffer WaveShadows { vec4 at[]; } waveShadows;
// Two queues of slots, which change places at each step
layout(set = 0, binding = 29, std430) WAVE_QUEUES_ACCESS buffer WaveQueue { uint at[]; } waveQueue;
// For each step the number of paths in its queue, and of shadow rays; starts at 0
layout(set = 0, binding = 30, std430) WAVE_QUEUES_ACCESS buffer WaveCounts { uint at[]; } waveCounts;
layout(push_constant) uniform Wave { WaveConstants value; } wave;

uint PixelCount() { return wave.value.size.x * wave.value.size.y; }
ivec2 TexelOf(uint slot) { return ivec2(slot % wave.value.size.x, slot / wave.value.size.x); }

// Of the step. In the first one, all texels have a path.
uint PathCount() { return wave.value.step == 0u ? PixelCount() : waveCounts.at[2u * wave.value.step]; }
uint SlotAt(uint i) {
    return wave.value.step == 0u ? i : waveQueue.at[(wave.value.step & 1u) * PixelCount() + i];
}

#ifdef WAVE_WRITES_QUEUES
// What the invocations of a group want of the queue of paths and of that of shadow rays, and where the
// group's places begin. One atomic operation a group: all invocations take part, and none relies on which of
// them a device runs in lockstep.
shared uint wantedPlaces[2];
shared uint firstPlaces[2];

// A place of its own in both queues for each invocation that wants one. Called in uniform control flow.
uvec2 TakePlaces(bool wantsPath, bool wantsShadow) {
    if (gl_LocalInvocationIndex < 2u) wantedPlaces[gl_LocalInvocationIndex] = 0u;
    barrier();
    uvec2 place = uvec2(0u);
    if (wantsPath) place.x = atomicAdd(wantedPlaces[0], 1u);
    if (wantsShadow) place.y = atomicAdd(wantedPlaces[1], 1u);
    barrier();
    uint queue = gl_LocalInvocationIndex;
    if (queue < 2u)
        firstPlaces[queue] =
            atomicAdd(waveCounts.at[2u * wave.value.step + (queue == 0u ? 2u : 1u)], wantedPlaces[queue]);
    barrier();
    return place + uvec2(firstPlaces[0], firstPlaces[1]);
}

// Into the queue of the next step.
void Enqueue(uint slot, uint place) {
    waveQueue.at[((wave.value.step + 1u) & 1u) * PixelCount() + place] = slot;
}
#endif

// ---------------------------------------------------------------------------------------------------- paths

// The rows of a path beyond the first ones. Not all kernels know of PATH_PARTS, whose rows are the last.
uint ConeRow() { return kWavePathRows; }
uint MediaRow() { return ConeRow() + (HasTraceFeature(kTraceTextureLod) ? kWaveConeRows : 0u); }
uint LobeRow() { return MediaRow() + (HasTraceFeature(kTraceVolumes) ? kWaveMediaRows : 0u); }
uint PathRows() { return wave.value.pathRows; }

MediumStack MediaFrom(vec4 row) {
    uvec4 materials = floatBitsToUint(row);
    MediumStack media;
    media.m0 = materials.x;
    media.m1 = materials.y;
    media.m2 = materials.z;
    media.m3 = materials.w;
    return media;
}
vec4 RowOf(MediumStack media) { return uintBitsToFloat(uvec4(media.m0, media.m1, media.m2, media.m3)); }

vec4 RowOf(FirstLobe lobe) { return vec4(lobe.diffuse, lobe.isThrough ? 1.0f : 0.0f); }
FirstLobe LobeFrom(vec4 row) {
    FirstLobe lobe;
    lobe.diffuse = row.xyz;
    lobe.isThrough = row.w > 0.0f;
    return lobe;
}

vec4 RowOf(SegmentStart start) { return vec4(start.normal, start.height); }
SegmentStart StartFrom(vec4 row) {
    SegmentStart start;
    start.normal = row.xyz;
    start.height = row.w;
    return start;
}

// Where the media around the origin of a camera ray are: behind all paths if they are the same for all.
uint CameraMediaRow(uint slot) {
    return PathRows() * (wave.value.isProbedOnce != 0u ? PixelCount() : slot) + MediaRow();
}
MediumStack LoadCameraMedia(uint slot) { return MediaFrom(wavePaths.at[CameraMediaRow(slot)]); }

// Its next ray.
Ray LoadRay(uint slot, out uint rayCount) {
    uint row = PathRows() * slot;
    vec4 first = wavePaths.at[row];
    Ray ray;
    ray.origin = first.xyz;
    rayCount = floatBitsToUint(first.w);
    ray.direction = wavePaths.at[row + 1u].xyz;
    ray.cone = MakeCone(0.0f, 0.0f);
    return ray;
}

// All but what it has collected (LoadOutputs).
PathState LoadPath(uint slot) {
    uint row = PathRows() * slot;
    uint rayCount = 0u;
    Ray ray = LoadRay(slot, rayCount);
    if (HasTraceFeature(kTraceTextureLod)) {
        vec4 cone = wavePaths.at[row + ConeRow()];
        ray.cone = MakeCone(cone.x, cone.y);
    }
    PathState path = StartPath(ray, RngOf(uvec2(TexelOf(slot))));
    path.rayCount = rayCount;
    path.scatterPDF = wavePaths.at[row + 1u].w;
    vec4 third = wavePaths.at[row + 2u];
    path.throughput = third.xyz;
    path.etaScale = third.w;
    vec4 fourth = wavePaths.at[row + 3u];
    path.scatter.position = fourth.xyz;
    path.depth = floatBitsToUint(fourth.w);
    vec4 fifth = wavePaths.at[row + 4u];
    path.scatter.normal = fifth.xyz;
    path.wavelength = fifth.w;
    if (kKeepsParts) path.lobe = LobeFrom(wavePaths.at[row + LobeRow()]);
    if (HasTraceFeature(kTraceVolumes)) {
        path.media = MediaFrom(wavePaths.at[row + MediaRow()]);
        path.start = StartFrom(wavePaths.at[row + MediaRow() + 1u]);
    }
    return path;
}

#ifdef WAVE_WRITES_PATHS
void StorePath(uint slot, PathState path) {
    uint row = PathRows() * slot;
    wavePaths.at[row] = vec4(path.ray.origin, uintBitsToFloat(path.rayCount));
    wavePaths.at[row + 1u] = vec4(path.ray.direction, path.scatterPDF);
    wavePaths.at[row + 2u] = vec4(path.throughput, path.etaScale);
    wavePaths.at[row + 3u] = vec4(path.scatter.position, uintBitsToFloat(path.depth));
    wavePaths.at[row + 4u] = vec4(path.scatter.normal, path.wavelength);
    if (kKeepsParts) wavePaths.at[row + LobeRow()] = RowOf(path.lobe);
    if (HasTraceFeature(kTraceTextureLod))
        wavePaths.at[row + ConeRow()] = vec4(path.ray.cone.width, path.ray.cone.spread, 0.0f, 0.0f);
    if (HasTraceFeature(kTraceVolumes)) {
        wavePaths.at[row + MediaRow()] = RowOf(path.media);
        wavePaths.at[row + MediaRow() + 1u] = RowOf(path.start);
    }
}

void StoreRayCount(uint slot, uint rayCount) {
    wavePaths.at[PathRows() * slot].w = uintBitsToFloat(rayCount);
}
void StoreCameraMedia(uint slot, MediumStack media) { wavePaths.at[CameraMediaRow(slot)] = RowOf(media); }
#endif

// ----------------------------------------------------------------------------------------------------- hits

#ifdef WAVE_WRITES_HITS
void StoreHit(uint slot, Hit hit) {
    waveHits.at[slot] = uvec4(hit.instance, hit.primitive, floatBitsToUint(hit.barycentrics));
    waveHits.at[PixelCount() + slot / 4u][slot % 4u] = floatBitsToUint(hit.t);
}
#endif

Hit LoadHit(uint slot) {
    uvec4 row = waveHits.at[slot];
    Hit hit;
    hit.instance = row.x;
    hit.primitive = row.y;
    hit.barycentrics = uintBitsToFloat(row.zw);
    hit.t = uintBitsToFloat(waveHits.at[PixelCount() + slot / 4u][slot % 4u]);
    return hit;
}

// ---------------------------------------------------------------------------------------------- shadow rays

uint ShadowLobeRow() { return kWaveShadowRows; }
uint ShadowMediaRow() { return ShadowLobeRow() + (kKeepsParts ? kWaveLobeRows : 0u); }
uint ShadowRows() {
    return ShadowMediaRow() + (HasTraceFeature(kTraceMatchedMedia) ? kWaveShadowMediaRows : 0u);
}

struct WaveShadow {
    DirectLight light;
    uint slot;
    uint depth;     // at which the light is added
    uint rayCount;  // of the path, this ray included
    float wavelength;
};

#ifdef WAVE_WRITES_SHADOWS
void StoreShadow(uint at, WaveShadow shadow) {
    uint row = ShadowRows() * at;
    DirectLight light = shadow.light;
    waveShadows.at[row] = vec4(light.ray.origin, light.distance);
    waveShadows.at[row + 1u] = vec4(light.ray.direction, light.ior);
    waveShadows.at[row + 2u] = vec4(light.radiance, uintBitsToFloat(shadow.slot));
    waveShadows.at[row + 3u] =
        uintBitsToFloat(uvec4(shadow.rayCount, shadow.depth, light.light, light.triangle));
    if (kKeepsParts) waveShadows.at[row + ShadowLobeRow()] = RowOf(light.lobe);
    if (HasTraceFeature(kTraceMatchedMedia)) {
        waveShadows.at[row + ShadowMediaRow()] = RowOf(light.media);
        waveShadows.at[row + ShadowMediaRow() + 1u] = RowOf(light.start);
        waveShadows.at[row + ShadowMediaRow() + 2u] = vec4(shadow.wavelength, vec3(0.0f));
    }
}
#endif

// Of the step before.
uint ShadowCount() { return waveCounts.at[2u * wave.value.step - 1u]; }

WaveShadow LoadShadow(uint at) {
    uint row = ShadowRows() * at;
    WaveShadow shadow;
    shadow.light = NoDirectLight();
    vec4 first = waveShadows.at[row];
    shadow.light.ray.origin = first.xyz;
    shadow.light.distance = first.w;
    vec4 second = waveShadows.at[row + 1u];
    shadow.light.ray.direction = second.xyz;
    shadow.light.ior = second.w;
    vec4 third = waveShadows.at[row + 2u];
    shadow.light.radiance = third.xyz;
    shadow.slot = floatBitsToUint(third.w);
    uvec4 fourth = floatBitsToUint(waveShadows.at[row + 3u]);
    shadow.rayCount = fourth.x;
    shadow.depth = fourth.y;
    shadow.light.light = fourth.z;
    shadow.light.triangle = fourth.w;
    shadow.wavelength = kNoWavelength;
    if (kKeepsParts) shadow.light.lobe = LobeFrom(waveShadows.at[row + ShadowLobeRow()]);
    if (HasTraceFeature(kTraceMatchedMedia)) {
        shadow.light.media = MediaFrom(waveShadows.at[row + ShadowMediaRow()]);
        shadow.light.start = StartFrom(waveShadows.at[row + ShadowMediaRow() + 1u]);
        shadow.wavelength = waveShadows.at[row + ShadowMediaRow() + 2u].x;
    }
    return shadow;
}

#endif
