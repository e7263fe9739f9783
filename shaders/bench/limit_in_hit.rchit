// Replaces the ray by the one that bounces off what it hit.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "scene/extensions.glsl"

#include "bench/limit_bounce.glsl"
#include "bench/limit_payload.glsl"

layout(location = 0) rayPayloadInEXT LimitPayload path;
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
    LimitBounce(hit, ray, path.rng);
    path.origin = ray.origin;
    path.t = hit.t;
    path.direction = ray.direction;
}
