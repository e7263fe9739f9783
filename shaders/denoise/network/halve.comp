// Writes the mean of each 2 x 2 pixels.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D finer;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D coarser;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), last = imageSize(finer) - 1;
    if (!IsInside(pixel, imageSize(coarser))) return;
    vec4 sum = vec4(0.0f);
    for (int i = 0; i < 4; ++i) sum += imageLoad(finer, min(2 * pixel + ivec2(i & 1, i >> 1), last));
    imageStore(coarser, pixel, 0.25f * sum);
}
