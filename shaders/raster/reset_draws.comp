// Initializes one command a draw, without instances.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "raster/invocation_stride.glsl"
#include "shared/draw_records.h"

layout(set = 0, binding = 0, scalar) readonly buffer Draws { DrawRecord at[]; } draws;
layout(set = 0, binding = 1, scalar) writeonly buffer Commands { DrawCommand at[]; } commands;
layout(push_constant, scalar) uniform Constants { uint count; uint slotsPerPlacement; } constants;

void main() {
    for (uint draw = gl_GlobalInvocationID.x; draw < constants.count; draw += InvocationStride()) {
        DrawCommand command;
        command.vertexCount = draws.at[draw].vertexCount;
        command.instanceCount = 0u;
        command.firstVertex = 0u;
        command.firstInstance = draws.at[draw].firstSlot * constants.slotsPerPlacement;
        commands.at[draw] = command;
    }
}
