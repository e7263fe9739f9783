// Tracing by ray type: the only place that turns a ray type into numbers of the shader binding table.
// Group order is that of rhi/shader_binding_table.h.
#ifndef RAYGRAPH_SCENE_TRACE_RAYS_GLSL
#define RAYGRAPH_SCENE_TRACE_RAYS_GLSL

#include "scene/bindings.glsl"
#include "scene/ray.glsl"
#include "shared/ray_types.h"

layout(location = 0) rayPayloadEXT Hit hitPayload;

// The nearest surface along a ray. Origins are moved off their surface beforehand (core/ray_offset.glsl): no
// tMin.
Hit Intersect(Ray ray) {
    // Backs are culled where the instance allows it. Stride 0: every geometry of an instance takes the
    // instance's hit set
    traceRayEXT(sceneTlas, gl_RayFlagsCullBackFacingTrianglesEXT, 0xFFu, kRayTypeRadiance, 0u,
                kRayTypeRadiance, ray.origin, 0.0f, ray.direction, 3.0e38f, 0);
    return hitPayload;
}

#endif
