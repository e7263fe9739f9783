// Puts each placement whose bounds may be in the picture into its draw's list. The order within a draw is
// that in which the invocations come: it matters where surfaces coincide, and nowhere else.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/projection.glsl"
#include "scene/bindings.glsl"
#include "shared/draw_records.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 16, scalar) writeonly buffer VisiblePlacements { uint at[]; } visiblePlacements;
layout(set = 0, binding = 17, scalar) readonly buffer Draws { DrawRecord at[]; } draws;
layout(set = 0, binding = 18, scalar) buffer Commands { DrawCommand at[]; } commands;
layout(push_constant, scalar) uniform Constants { vec2 shift; uint count; } constants;

// False: the whole box is beyond one side of the picture, or behind the camera.
bool MayBeSeen(CameraRecord camera, mat4x3 objectToWorld, vec3 low, vec3 high) {
    uint outsideOfAll = 0x3Fu;
    for (uint corner = 0u; corner < 8u; corner++) {
        vec3 at = vec3((corner & 1u) != 0u ? high.x : low.x, (corner & 2u) != 0u ? high.y : low.y,
                       (corner & 4u) != 0u ? high.z : low.z);
        vec4 clip = ClipPosition(camera, objectToWorld * vec4(at, 1.0f), constants.shift);
        uint outside = 0u;
        if (clip.x < -clip.w) outside |= 1u;
        if (clip.x > clip.w) outside |= 2u;
        if (clip.y < -clip.w) outside |= 4u;
        if (clip.y > clip.w) outside |= 8u;
        if (clip.z > clip.w) outside |= 16u;  // nearer than zNear, or behind
        if (clip.z < 0.0f) outside |= 32u;
        outsideOfAll &= outside;
    }
    return outsideOfAll == 0u;
}

void main() {
    uint placement = gl_GlobalInvocationID.x;
    if (placement >= constants.count) return;
    uint draw = instances.at[placement].draw;
    if (draw == kNotDrawn) return;
    DrawRecord record = draws.at[draw];
    if (!MayBeSeen(parameters.value.camera, instances.at[placement].objectToWorld, record.boundsMin,
                   record.boundsMax))
        return;
    uint place = atomicAdd(commands.at[draw].instanceCount, 1u);
    visiblePlacements.at[record.firstSlot + place] = placement;
}
