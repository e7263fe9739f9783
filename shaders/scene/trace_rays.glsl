// Tracing by ray type: the only place that turns a ray type into numbers of the shader binding table. Group
// order is that of rhi/shader_binding_table.h. Stride 0: every geometry of an instance takes the instance's
// hit set. Back faces are culled where the instance allows it. Origins are offset from their surface
// beforehand (core/ray_offset.glsl): no tMin. A pass whose radiance rays have a payload of their own declares
// it at location 0, defines OWN_RADIANCE_PAYLOAD, and traces by TraceRadiance.
//
// Where SOFTWARE_TRAVERSAL is defined, and NO_TLAS, Intersect and ShadowTransmittance traverse the scene's
// own trees in place of the driver's (scene/software_traversal.glsl): with the same answers, but at edges.
#ifndef RAYGRAPH_SCENE_TRACE_RAYS_GLSL
#define RAYGRAPH_SCENE_TRACE_RAYS_GLSL

#include "core/trace_options.glsl"
#include "scene/bindings.glsl"
#include "scene/payloads.glsl"
#include "shared/ray_types.h"

SHADING_BEGIN

CONST float kFarthest = 3.0e38f;

SHADING_END

#ifdef SOFTWARE_TRAVERSAL
#include "scene/software_traversal.glsl"

SHADING_BEGIN

INLINE Hit Intersect(Ray ray, uint alphaSeed) { return HitWithin(ray, kFarthest, false, alphaSeed); }
#ifdef SINGLE_TRACE_CALL
INLINE Hit IntersectWithin(Ray ray, float distance, bool terminateOnFirstHit, uint alphaSeed) {
    return HitWithin(ray, min(distance, kFarthest), terminateOnFirstHit, alphaSeed);
}
#endif
#ifdef TRACES_SHADOW_RAYS
INLINE vec3 ShadowTransmittance(Ray ray, float distance, float ior, uint alphaSeed) {
    return TransmittanceUpTo(ray, min(distance, kFarthest), ior, alphaSeed);
}
#endif

SHADING_END
#else

#ifndef OWN_RADIANCE_PAYLOAD
layout(location = 0) rayPayloadEXT RadiancePayload radiancePayload;
#endif
#ifdef TRACES_SHADOW_RAYS
layout(location = 1) rayPayloadEXT ShadowPayload shadowPayload;
#endif

#ifndef RAY_MASK
#define RAY_MASK 0xFFu  // kMaskTriangles, kMaskRound: only those
#endif

// Runs the closest-hit shader of the nearest surface along a ray, or the miss shader, on the payload at
// location 0. `flags`: further ones.
void TraceRadiance(Ray ray, float distance, uint flags) {
    // Thin walls are opaque to these rays; only shadow rays pass through them
    flags |= gl_RayFlagsCullBackFacingTrianglesEXT;
    if (!HasTraceFeature(kTraceAnyHit)) flags |= gl_RayFlagsOpaqueEXT;
    traceRayEXT(sceneTlas, flags, RAY_MASK, kRayTypeRadiance, 0u, kRayTypeRadiance, ray.origin, 0.0f,
                ray.direction, min(distance, kFarthest), 0);
}
void TraceRadiance(Ray ray) { TraceRadiance(ray, kFarthest, 0u); }

#ifndef OWN_RADIANCE_PAYLOAD
// Returns the nearest surface along a ray. Alpha tests use a random number that is a function of alphaSeed
// and the triangle.
Hit Intersect(Ray ray, uint alphaSeed) {
    radiancePayload.alphaSeed = alphaSeed;
    TraceRadiance(ray);
    return radiancePayload.hit;
}

#ifdef SINGLE_TRACE_CALL
// Returns Intersect up to a distance. If `terminateOnFirstHit`, the hit only says whether there is a surface.
Hit IntersectWithin(Ray ray, float distance, bool terminateOnFirstHit, uint alphaSeed) {
    const uint any = gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsSkipClosestHitShaderEXT;
    radiancePayload.alphaSeed = alphaSeed;
    radiancePayload.hit.t = 0.0f;  // a hit, unless the miss shader runs
    TraceRadiance(ray, distance, terminateOnFirstHit ? any : 0u);
    return radiancePayload.hit;
}
#endif
#endif

#ifdef TRACES_SHADOW_RAYS
// Transmittance along the ray up to `distance` (infinity is legal): 0 if an opaque surface is nearer, less
// than 1 through smooth thin walls. `ior` is of the medium that the ray starts in.
vec3 ShadowTransmittance(Ray ray, float distance, float ior, uint alphaSeed) {
    const uint flags = gl_RayFlagsCullBackFacingTrianglesEXT | gl_RayFlagsTerminateOnFirstHitEXT |
                       gl_RayFlagsSkipClosestHitShaderEXT;
    shadowPayload.passed = vec3(1.0f);
    shadowPayload.lastDistance = -1.0f;
    shadowPayload.ior = ior;
    shadowPayload.alphaSeed = alphaSeed;
    traceRayEXT(sceneTlas, flags, 0xFFu, kRayTypeShadow, 0u, kRayTypeShadow, ray.origin, 0.0f, ray.direction,
                min(distance, kFarthest), 1);
    bool isFree = shadowPayload.lastDistance == kShadowRayArrived;
    if (HasTraceFeature(kTraceThinWalls)) return isFree ? shadowPayload.passed : vec3(0.0f);
    return vec3(isFree ? 1.0f : 0.0f);
}
#endif

#endif  // SOFTWARE_TRAVERSAL

#endif
