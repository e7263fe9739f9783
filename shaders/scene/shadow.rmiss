// Miss shader of shadow rays: no occluder.
#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require
#include "scene/payloads.glsl"

layout(location = 0) rayPayloadInEXT ShadowPayload shadowPayload;

void main() { shadowPayload.lastDistance = kShadowRayArrived; }
