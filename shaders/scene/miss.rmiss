// Miss shader of radiance rays.
#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require
#include "scene/payloads.glsl"

layout(location = 0) rayPayloadInEXT RadiancePayload radiancePayload;

void main() { radiancePayload.hit.t = -1.0f; }
