// Traces the next ray of a path from the surface that the last one found; multiplies on the way back.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "scene/extensions.glsl"

#include "bench/lambert_path.glsl"
#include "bench/lambert_payload.glsl"

layout(location = 0) rayPayloadInEXT LambertPayload path;  // holds this ray's path, and then the next ray's
#define OWN_RADIANCE_PAYLOAD
#include "scene/trace_rays.glsl"

hitAttributeEXT vec2 attributes;

void main() {
    Hit hit;
    hit.t = gl_HitTEXT;
    hit.instance = gl_InstanceCustomIndexEXT;
    hit.primitive = gl_PrimitiveID;
    hit.barycentrics = attributes;
    Ray ray;
    ray.origin = gl_WorldRayOriginEXT;
    ray.direction = gl_WorldRayDirectionEXT;
    SurfaceInteraction surface = SurfaceAt(hit, ray);
    if (EndsLambertPath(surface, path.depth)) {
        path.radiance = surface.emission;
        return;
    }
    ++path.depth;
    TraceRadiance(ScatterLambert(surface, path.rng));
    path.radiance = surface.emission + surface.material.baseColor * path.radiance;
}
