// 1 for the candidate with the smallest error around the pixel, and 0 for the others.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D errors;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D choice;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(errors);
    if (!IsInside(pixel, size)) return;
    ivec2 begin = WindowBegin(pixel, 4), end = WindowEnd(pixel, 4, size);
    vec3 sums = vec3(0.0f);
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) sums += imageLoad(errors, ivec2(x, y)).xyz;
    bool isDetailed = sums.x <= min(sums.y, sums.z), isMedium = !isDetailed && sums.y <= sums.z;
    imageStore(choice, pixel, vec4(isDetailed, isMedium, !isDetailed && !isMedium, 0.0f));
}
