// Nothing is on the ray.
#version 460
#extension GL_EXT_ray_tracing : require

layout(location = 0) rayPayloadInEXT float freeDistance;

void main() { freeDistance = -1.0f; }
