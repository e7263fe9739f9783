// Tracing by ray type: the only place that turns a ray type into numbers of the shader binding table.
// Group order is that of rhi/shader_binding_table.h. Stride 0: every geometry of an instance takes the
// instance's hit set. Backs are culled where the instance allows it. Origins are moved off their surface
// beforehand (core/ray_offset.glsl): no tMin.
#ifndef RAYGRAPH_SCENE_TRACE_RAYS_GLSL
#define RAYGRAPH_SCENE_TRACE_RAYS_GLSL

#include "scene/bindings.glsl"
#include "scene/payloads.glsl"
#include "shared/ray_types.h"

layout(location = 0) rayPayloadEXT RadiancePayload radiancePayload;
#ifdef TRACES_SHADOW_RAYS
layout(location = 1) rayPayloadEXT ShadowPayload shadowPayload;
#endif

const float kFarthest = 3.0e38f;

// The nearest surface along a ray. Partly transparent surfaces are there or not by a number that alphaSeed
// and the triangle give.
Hit Intersect(Ray ray, uint alphaSeed) {
    radiancePayload.alphaSeed = alphaSeed;
    traceRayEXT(sceneTlas, gl_RayFlagsCullBackFacingTrianglesEXT, 0xFFu, kRayTypeRadiance, 0u,
                kRayTypeRadiance, ray.origin, 0.0f, ray.direction, kFarthest, 0);
    return radiancePayload.hit;
}

#ifdef TRACES_SHADOW_RAYS
// Nothing is on the ray before `distance` (infinity is legal).
bool Unoccluded(Ray ray, float distance, uint alphaSeed) {
    shadowPayload.alphaSeed = alphaSeed;
    shadowPayload.isOccluded = 1u;
    const uint flags = gl_RayFlagsCullBackFacingTrianglesEXT | gl_RayFlagsTerminateOnFirstHitEXT |
                       gl_RayFlagsSkipClosestHitShaderEXT;
    traceRayEXT(sceneTlas, flags, 0xFFu, kRayTypeShadow, 0u, kRayTypeShadow, ray.origin, 0.0f, ray.direction,
                min(distance, kFarthest), 1);
    return shadowPayload.isOccluded == 0u;
}
#endif

#endif
