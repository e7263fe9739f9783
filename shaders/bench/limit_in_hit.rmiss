// The path of bench/limit_in_hit.rgen left the scene.
#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require
#include "bench/limit_payload.glsl"

layout(location = 0) rayPayloadInEXT LimitPayload path;

void main() { path.t = -1.0f; }
