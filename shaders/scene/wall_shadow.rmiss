// Miss of a shadow ray in a scene with smooth thin walls: nothing else is in between.
#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require
#include "scene/payloads.glsl"

layout(location = 0) rayPayloadInEXT WallShadowPayload wallShadowPayload;

void main() { wallShadowPayload.isOccluded = 0u; }
