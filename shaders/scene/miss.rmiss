// Miss of every ray that wants a surface.
#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require
#include "scene/ray.glsl"

layout(location = 0) rayPayloadInEXT Hit hitPayload;

void main() { hitPayload.t = -1.0f; }
