// Adds up the luminance and its square root in blocks of 16 x 16 pixels, for the exposure of the network.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "core/color.glsl"
#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D target;
layout(set = 0, binding = 1, rg32f) writeonly uniform image2D sums;

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (!IsInside(block, imageSize(sums))) return;
    ivec2 begin = 16 * block, end = min(begin + 16, imageSize(target));
    vec2 sum = vec2(0.0f);
    for (int y = begin.y; y < end.y; ++y)
        for (int x = begin.x; x < end.x; ++x) {
            float luminance = max(Luminance(imageLoad(target, ivec2(x, y)).xyz), 0.0f);
            sum += vec2(luminance, sqrt(luminance));
        }
    imageStore(sums, block, vec4(sum, 0.0f, 0.0f));
}
