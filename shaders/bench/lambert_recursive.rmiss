// A path that left the scene.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "scene/extensions.glsl"

#include "bench/lambert_payload.glsl"
#include "scene/bindings.glsl"

layout(location = 0) rayPayloadInEXT LambertPayload path;

void main() { path.radiance = parameters.value.environment.radiance; }
