// The data that the kernels of a wavefront pass on (passes/wavefront.cpp): the state of the paths, the hits
// of their rays, their shadow rays, and the queues. A path keeps one slot, its texel's number, as long as it
// lives; the queues name the slots of those that do. Records are rows of 16 bytes, one after the other, so
// that a path is read by few transactions wherever its slot is.
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
// For each step the number of paths in its queue, none in the first, and of shadow rays; starts at 0
layout(set = 0, binding = 30, std430) WAVE_QUEUES_ACCESS buffer WaveCounts { uint at[]; } waveCounts;
layout(push_constant) uniform Wave { WaveConstants value; } wave;

uint PixelCount() { return wave.value.size.x * wave.value.size.y; }
ivec2 TexelOf(uint slot) { return ivec2(slot % wave.value.size.x, slot / wave.value.size.x); }

// Returns the number of paths in the step. In the first one, all texels have a path.
uint PathCount() { return wave.value.step == 0u ? PixelCount() : waveCounts.at[2u * wave.value.step]; }
uint SlotAt(uint i) {
    return wave.value.step == 0u ? i : waveQueue.at[(wave.value.step & 1u) * PixelCount() + i];
}

#ifdef WAVE_WRITES_QUEUES
// The number of places that a group takes in the queue of paths and in that of shadow rays, and the first of
// them. One atomic operation a group: all invocations take part, and none relies on which of them a device
// runs in lockstep.
shared uint requestedEntries[2];
shared uint firstEntries[2];

// Reserves an entry of its own in both queues for each invocation that wants one. Must be called in uniform
// control flow.
uvec2 ReserveQueueEntries(bool wantsPath, bool wantsShadow) {
    if (gl_LocalInvocationIndex < 2u) requestedEntries[gl_LocalInvocationIndex] = 0u;
    barrier();
    uvec2 place = uvec2(0u);
    if (wantsPath) place.x = atomicAdd(requestedEntries[0], 1u);
    if (wantsShadow) place.y = atomicAdd(requestedEntries[1], 1u);
    barrier();
    uint queue = gl_LocalInvocationIndex;
    if (queue < 2u)
        firstEntries[queue] =
            atomicAdd(waveCounts.at[2u * wave.value.step + (queue == 0u ? 2u : 1u)], requestedEntries[queue]);
    barrier();
    return place + uvec2(firstEntries[0], firstEntries[1]);
}

// Adds a path to the queue of the next step.
void Enqueue(uint slot, uint place) {
    waveQueue.at[((wave.value.step + 1u) & 1u) * PixelCount() + place] = slot;
}
#endif

// ----------------------------------------------------------------------------------------------------- rows

// The macros from which the lists of shared/wavefront.h are made: conditions, and for each kind of row the
// expression that is stored of its members, and their expressions in terms of `stored`.
#define KeepsParts() kKeepsParts

#define WAVE_STORED_VEC3_FLOAT(xyz, w) vec4(xyz, w)
#define WAVE_STORED_VEC3_UINT(xyz, w)  vec4(xyz, uintBitsToFloat(w))
#define WAVE_STORED_VEC3_BOOL(xyz, w)  vec4(xyz, (w) ? 1.0f : 0.0f)
#define WAVE_STORED_UINTS(x, y, z, w)  uintBitsToFloat(uvec4(x, y, z, w))
#define WAVE_STORED_FLOATS(x, y)       vec4(x, y, 0.0f, 0.0f)
#define WAVE_STORED_FLOAT(x)           vec4(x, vec3(0.0f))

#define WAVE_LOAD_VEC3_FLOAT(a, b) a = stored.xyz; b = stored.w;
#define WAVE_LOAD_VEC3_UINT(a, b)  a = stored.xyz; b = floatBitsToUint(stored.w);
#define WAVE_LOAD_VEC3_BOOL(a, b)  a = stored.xyz; b = stored.w > 0.0f;
#define WAVE_LOAD_UINTS(a, b, c, d) \
    uvec4 bits = floatBitsToUint(stored); a = bits.x; b = bits.y; c = bits.z; d = bits.w;
#define WAVE_LOAD_FLOATS(a, b)     a = stored.x; b = stored.y;
#define WAVE_LOAD_FLOAT(a)         a = stored.x;

// ---------------------------------------------------------------------------------------------------- paths

#define WAVE_LOAD_PATH_ROW(condition, members) \
    if (condition) { vec4 stored = wavePaths.at[row++]; WAVE_LOAD_##members }
#define WAVE_STORE_PATH_ROW(condition, members) \
    if (condition) wavePaths.at[row++] = WAVE_STORED_##members;

// Returns the first row of a path. Not all kernels know how many rows a path has, which depends on
// PATH_PARTS.
uint PathRow(uint slot) { return wave.value.pathRows * slot; }

// Returns the row of the media around the origin of a camera ray: that of the path, which is stored later, or
// one behind all paths if they are the same for all.
uint CameraMediaRow(uint slot) { return PathRow(wave.value.isProbedOnce != 0u ? PixelCount() : slot); }
MediumStack LoadCameraMedia(uint slot) {
    MediumStack media;
    vec4 stored = wavePaths.at[CameraMediaRow(slot)];
    WAVE_LOAD_UINTS(media.m0, media.m1, media.m2, media.m3)
    return media;
}

// Loads only the path's next ray, and how many it has traced.
PathState LoadRay(uint slot) {
    PathState path;
    path.ray.cone = MakeCone(0.0f, 0.0f);
    uint row = PathRow(slot);
    RAYGRAPH_WAVE_RAY_ROWS(WAVE_LOAD_PATH_ROW)
    return path;
}

// Loads all but the light that the path has collected (LoadOutputs).
PathState LoadPath(uint slot) {
    Ray ray;
    ray.origin = vec3(0.0f);
    ray.direction = vec3(0.0f);
    ray.cone = MakeCone(0.0f, 0.0f);
    PathState path = StartPath(ray, RngOf(uvec2(TexelOf(slot))));
    uint row = PathRow(slot);
    RAYGRAPH_WAVE_PATH_ROWS(WAVE_LOAD_PATH_ROW)
    return path;
}

#ifdef WAVE_WRITES_PATHS
void StorePath(uint slot, PathState path) {
    uint row = PathRow(slot);
    RAYGRAPH_WAVE_PATH_ROWS(WAVE_STORE_PATH_ROW)
}

// The count is at the end of the first row.
void StoreRayCount(uint slot, uint rayCount) { wavePaths.at[PathRow(slot)].w = uintBitsToFloat(rayCount); }
void StoreCameraMedia(uint slot, MediumStack media) {
    wavePaths.at[CameraMediaRow(slot)] = WAVE_STORED_UINTS(media.m0, media.m1, media.m2, media.m3);
}
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

struct WaveShadow {
    DirectLight light;
    uint slot;
    uint depth;     // at which the light is added
    uint rayCount;  // rays of the path, this ray included
    float wavelength;
};

#define WAVE_LOAD_SHADOW_ROW(condition, members) \
    if (condition) { vec4 stored = waveShadows.at[row++]; WAVE_LOAD_##members }
#define WAVE_STORE_SHADOW_ROW(condition, members) \
    if (condition) waveShadows.at[row++] = WAVE_STORED_##members;

uint ShadowRow(uint at) { return (0u RAYGRAPH_WAVE_SHADOW_ROWS(RAYGRAPH_WAVE_COUNT_ROW)) * at; }

#ifdef WAVE_WRITES_SHADOWS
void StoreShadow(uint at, WaveShadow shadow) {
    uint row = ShadowRow(at);
    RAYGRAPH_WAVE_SHADOW_ROWS(WAVE_STORE_SHADOW_ROW)
}
#endif

// Returns the number of shadow rays of the step before.
uint ShadowCount() { return waveCounts.at[2u * wave.value.step - 1u]; }

WaveShadow LoadShadow(uint at) {
    WaveShadow shadow;
    shadow.light = NoDirectLight();
    shadow.wavelength = kNoWavelength;
    uint row = ShadowRow(at);
    RAYGRAPH_WAVE_SHADOW_ROWS(WAVE_LOAD_SHADOW_ROW)
    return shadow;
}

#endif
