// The rays of a buffer by scene/wide_bvh.glsl, one an invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/wide_bvh.h"

layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kIsAny = false;    // any hit: its sign alone is stored
layout(constant_id = 1) const bool kCounts = false;   // stores what it took
layout(constant_id = 2) const uint kSharedGroups = 0u;  // so many of the stack are in shared memory

layout(set = 0, binding = 0, std430) readonly buffer WideNodes { uvec4 at[]; } wideNodes;
layout(set = 0, binding = 1, std430) readonly buffer WideTriangles { uvec4 at[]; } wideTriangles;
layout(set = 0, binding = 2, std430) readonly buffer WideInstances { uvec4 at[]; } wideInstances;
layout(set = 0, binding = 3, scalar) readonly buffer Rays { BenchRay at[]; } rays;
layout(set = 0, binding = 4, scalar) writeonly buffer Hits { WideHit at[]; } hits;
layout(set = 0, binding = 5, scalar) writeonly buffer Counts { WideCounts at[]; } counts;
layout(push_constant, scalar) uniform Constants { BenchConstants constants; };

uvec4 WideNodeWord(uint at) { return wideNodes.at[at]; }
uvec4 WideTriangleWord(uint at) { return wideTriangles.at[at]; }
uvec4 WideInstanceWord(uint at) { return wideInstances.at[at]; }

uvec2 groupStack[kWideStackSize];
shared uvec2 sharedStack[(kSharedGroups > 0u ? kSharedGroups : 1u) * gl_WorkGroupSize.x];

void PushGroup(uint at, uvec2 group) {
    if (at < kSharedGroups)
        sharedStack[at * gl_WorkGroupSize.x + gl_LocalInvocationIndex] = group;
    else
        groupStack[at - kSharedGroups] = group;
}
uvec2 GroupAt(uint at) {
    if (at < kSharedGroups) return sharedStack[at * gl_WorkGroupSize.x + gl_LocalInvocationIndex];
    return groupStack[at - kSharedGroups];
}

bool IsAccepted(WideHit hit, bool isBack, bool isAny) { return true; }

#include "scene/wide_bvh.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= constants.rayCount) return;
    BenchRay ray = rays.at[index];
    WideCounts taken;
    taken.nodes = 0u;
    taken.triangles = 0u;
    taken.instances = 0u;
    WideHit hit = TraverseWide(ray.origin, ray.direction, ray.tMax, kIsAny, false, taken);
    if (kIsAny)
        hits.at[index].t = hit.t;
    else
        hits.at[index] = hit;
    if (kCounts) counts.at[index] = taken;
}
