// The rays of a buffer by scene/wide_bvh.glsl, nearest hits: nothing but a load, the traversal and a store.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "scene/words.glsl"
#include "shared/wide_bvh.h"

layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kHasOneLevel = false;

layout(set = 0, binding = 0, std430) readonly buffer WideNodes { u64vec2 at[]; } wideNodes;
layout(set = 0, binding = 1, std430) readonly buffer WideTriangles { u64vec2 at[]; } wideTriangles;
layout(set = 0, binding = 2, std430) readonly buffer WideInstances { u64vec2 at[]; } wideInstances;
layout(set = 0, binding = 3, scalar) readonly buffer Rays { BenchRay at[]; } rays;
layout(set = 0, binding = 4, scalar) writeonly buffer Hits { WideHit at[]; } hits;
layout(push_constant, scalar) uniform Constants { BenchConstants constants; };

uvec4 WideNodeWord(uint at) { return HalvesOf(wideNodes.at[at]); }
uvec4 WideTriangleWord(uint at) { return HalvesOf(wideTriangles.at[at]); }
uvec4 WideInstanceWord(uint at) { return HalvesOf(wideInstances.at[at]); }

uvec2 groupStack[kWideStackSize];
void PushGroup(uint at, uvec2 group) { groupStack[at] = group; }
uvec2 GroupAt(uint at) { return groupStack[at]; }

bool IsAccepted(WideHit hit, bool isBack, bool isAny) { return true; }

#include "scene/wide_bvh.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= constants.rayCount) return;
    BenchRay ray = rays.at[index];
    WideCounts taken;  // nobody asks for them
    taken.nodes = 0u;
    taken.triangles = 0u;
    taken.instances = 0u;
    hits.at[index] = TraverseWide(ray.origin, ray.direction, ray.tMax, false, kHasOneLevel, taken);
}
