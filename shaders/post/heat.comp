// Heat: one number a pixel in false color, see core/ramp.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "core/ramp.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32f) readonly uniform image2D values;
layout(set = 0, binding = 1, rgba8) writeonly uniform image2D display;

layout(push_constant) uniform Constants { float maximum; } constants;  // shown in the last color

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(display)))) return;
    float value = imageLoad(values, pixel).x / constants.maximum;
    float shown = value > 0.0f ? min(value, 1.0f) : 0.0f;  // NaN is 0
    imageStore(display, pixel, vec4(SrgbEncode(HeatColor(shown)), 1.0f));
}
