// Puts each placement whose bounds may be in the picture into its draw's list. The order within a draw is
// that in which the invocations run: it affects only coinciding surfaces.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/invocation_stride.glsl"
#include "raster/projection.glsl"
#include "scene/bindings.glsl"
#include "shared/draw_records.h"

layout(set = 0, binding = 16, scalar) writeonly buffer VisiblePlacements { uint at[]; } visiblePlacements;
layout(set = 0, binding = 17, scalar) readonly buffer Draws { DrawRecord at[]; } draws;
layout(set = 0, binding = 18, scalar) buffer Commands { DrawCommand at[]; } commands;
layout(push_constant, scalar) uniform Constants { vec2 shift; uint count; } constants;

void CullPlacement(uint placement) {
    uint draw = instances.at[placement].draw;
    if (draw == kNotDrawn) return;
    DrawRecord record = draws.at[draw];
    if (!IntersectsFrustum(parameters.value.camera, instances.at[placement].objectToWorld, record.boundsMin,
                   record.boundsMax, constants.shift))
        return;
    uint place = atomicAdd(commands.at[draw].instanceCount, 1u);
    visiblePlacements.at[record.firstSlot + place] = placement;
}

void main() {
    for (uint i = gl_GlobalInvocationID.x; i < constants.count; i += InvocationStride()) CullPlacement(i);
}
