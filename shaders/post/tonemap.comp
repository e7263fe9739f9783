// Tonemap: radiance to display values.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "core/tonemap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2D radiance;
layout(set = 0, binding = 1, rgba8) writeonly uniform image2D display;

layout(push_constant) uniform Constants {
    float exposureEv;
    uint tonemapOperator;
} constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(display)))) return;
    vec4 value = texelFetch(radiance, pixel, 0);
    vec3 shown = Tonemap(value.xyz, constants.exposureEv, constants.tonemapOperator);
    imageStore(display, pixel, vec4(shown, clamp(value.w, 0.0f, 1.0f)));
}
