// Closest hit of every ray that wants a surface: says what was hit and looks nothing up.
#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require
#include "scene/ray.glsl"

layout(location = 0) rayPayloadInEXT Hit hitPayload;
hitAttributeEXT vec2 attributes;

void main() {
    hitPayload.t = gl_HitTEXT;
    hitPayload.instance = gl_InstanceCustomIndexEXT;
    hitPayload.primitive = gl_PrimitiveID;
    hitPayload.barycentrics = attributes;
}
