// Initializes one command a draw, without instances.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/draw_records.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, scalar) readonly buffer Draws { DrawRecord at[]; } draws;
layout(set = 0, binding = 1, scalar) writeonly buffer Commands { DrawCommand at[]; } commands;
layout(push_constant, scalar) uniform Constants { uint count; uint slotsPerPlacement; } constants;

void main() {
    uint draw = gl_GlobalInvocationID.x;
    if (draw >= constants.count) return;
    DrawCommand command;
    command.vertexCount = draws.at[draw].vertexCount;
    command.instanceCount = 0u;
    command.firstVertex = 0u;
    command.firstInstance = draws.at[draw].firstSlot * constants.slotsPerPlacement;
    commands.at[draw] = command;
}
