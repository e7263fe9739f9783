// Closest-hit shader of radiance rays: returns the hit without looking up attributes.
#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require
#include "scene/payloads.glsl"

layout(location = 0) rayPayloadInEXT RadiancePayload radiancePayload;
hitAttributeEXT vec2 attributes;

void main() {
    radiancePayload.hit.t = gl_HitTEXT;
    radiancePayload.hit.instance = gl_InstanceCustomIndexEXT;
    radiancePayload.hit.primitive = gl_PrimitiveID;
    radiancePayload.hit.barycentrics = attributes;
}
