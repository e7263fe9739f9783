// SceneBounds: the box around all placements that are drawn.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/invocation_stride.glsl"
#include "raster/scene_bounds.glsl"
#include "scene/bindings.glsl"
#include "shared/draw_records.h"

layout(set = 0, binding = 16, scalar) readonly buffer Draws { DrawRecord at[]; } draws;
layout(set = 0, binding = 17, scalar) buffer Bounds { SceneBoundsRecord value; } bounds;  // starts at 0
layout(push_constant, scalar) uniform Constants { uint count; } constants;

shared uint groupBounds[6];

void main() {
    uint lane = gl_LocalInvocationIndex;
    if (lane < 6u) groupBounds[lane] = 0u;
    barrier();
    for (uint placement = gl_GlobalInvocationID.x; placement < constants.count;
         placement += InvocationStride()) {
        if (instances.at[placement].draw == kNotDrawn) continue;
        mat4x3 objectToWorld = instances.at[placement].objectToWorld;
        DrawRecord draw = draws.at[instances.at[placement].draw];
        // The box is turned with the object: center, and half its size along each axis of the world.
        vec3 center = objectToWorld * vec4(0.5f * (draw.boundsMin + draw.boundsMax), 1.0f);
        vec3 halfSize = 0.5f * (draw.boundsMax - draw.boundsMin);
        vec3 reach = abs(objectToWorld[0]) * halfSize.x + abs(objectToWorld[1]) * halfSize.y +
                     abs(objectToWorld[2]) * halfSize.z;
        for (uint axis = 0u; axis < 3u; ++axis) {
            atomicMax(groupBounds[axis], OrderedBits(reach[axis] - center[axis]));
            atomicMax(groupBounds[3u + axis], OrderedBits(center[axis] + reach[axis]));
        }
    }
    barrier();
    if (lane < 3u) atomicMax(bounds.value.negatedMin[lane], groupBounds[lane]);
    if (lane >= 3u && lane < 6u) atomicMax(bounds.value.max[lane - 3u], groupBounds[lane]);
}
