// Tracing by ray type: the only place that turns a ray type into numbers of the shader binding table.
// Group order is that of rhi/shader_binding_table.h. Stride 0: every geometry of an instance takes the
// instance's hit set. Backs are culled where the instance allows it. Origins are moved off their surface
// beforehand (core/ray_offset.glsl): no tMin. A pass whose radiance rays carry something of their own
// declares it at location 0, defines OWN_RADIANCE_PAYLOAD, and traces by TraceRadiance.
#ifndef RAYGRAPH_SCENE_TRACE_RAYS_GLSL
#define RAYGRAPH_SCENE_TRACE_RAYS_GLSL

#include "scene/bindings.glsl"
#include "scene/payloads.glsl"
#include "shared/ray_types.h"

#ifndef OWN_RADIANCE_PAYLOAD
layout(location = 0) rayPayloadEXT RadiancePayload radiancePayload;
#endif
#ifdef TRACES_SHADOW_RAYS
layout(location = 1) rayPayloadEXT ShadowPayload shadowPayload;
#endif

const float kFarthest = 3.0e38f;

// Runs the closest-hit shader of the nearest surface along a ray, or the miss shader, on the payload at
// location 0.
void TraceRadiance(Ray ray) {
    traceRayEXT(sceneTlas, gl_RayFlagsCullBackFacingTrianglesEXT, 0xFFu, kRayTypeRadiance, 0u,
                kRayTypeRadiance, ray.origin, 0.0f, ray.direction, kFarthest, 0);
}

#ifndef OWN_RADIANCE_PAYLOAD
// The nearest surface along a ray. Partly transparent surfaces are there or not by a number that alphaSeed
// and the triangle give.
Hit Intersect(Ray ray, uint alphaSeed) {
    radiancePayload.alphaSeed = alphaSeed;
    TraceRadiance(ray);
    return radiancePayload.hit;
}
#endif

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
