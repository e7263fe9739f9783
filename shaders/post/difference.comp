// Difference: the absolute difference of two pictures, channel by channel.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "core/color.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D a;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D b;
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D difference;
layout(set = 0, binding = 3, r32f) writeonly uniform image2D luminance;  // luminance of the difference

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(difference)))) return;
    vec3 apart = abs(imageLoad(a, pixel).xyz - imageLoad(b, pixel).xyz);
    imageStore(difference, pixel, vec4(apart, 1.0f));
    imageStore(luminance, pixel, vec4(Luminance(apart)));
}
