// Puts each placement whose bounds may be in a shadow view into its draw's list, once for each such view.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/invocation_stride.glsl"
#include "raster/projection.glsl"
#include "scene/bindings.glsl"
#include "shared/draw_records.h"
#include "shared/shadow_records.h"

layout(set = 0, binding = 16, scalar) writeonly buffer Casters { ShadowCaster at[]; } casters;
layout(set = 0, binding = 17, scalar) readonly buffer Draws { DrawRecord at[]; } draws;
layout(set = 0, binding = 18, scalar) buffer Commands { DrawCommand at[]; } commands;
layout(set = 0, binding = 19, scalar) readonly buffer ShadowViews { ShadowView at[]; } shadowViews;
layout(push_constant, scalar) uniform Constants { uint count; uint viewSlots; } constants;

void CullPlacement(uint placement, uint view) {
    uint draw = instances.at[placement].draw;
    if (draw == kNotDrawn) return;
    DrawRecord record = draws.at[draw];
    if (!IntersectsFrustum(shadowViews.at[view].camera, instances.at[placement].objectToWorld,
                           record.boundsMin, record.boundsMax, vec2(0.0f)))
        return;
    ShadowCaster caster;
    caster.placement = placement;
    caster.view = view;
    uint place = atomicAdd(commands.at[draw].instanceCount, 1u);
    casters.at[record.firstSlot * constants.viewSlots + place] = caster;
}

void main() {
    uint view = gl_WorkGroupID.y;
    if (shadowViews.at[view].light == kNoLight) return;
    for (uint i = gl_GlobalInvocationID.x; i < constants.count; i += InvocationStride())
        CullPlacement(i, view);
}
