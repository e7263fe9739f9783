// 1 where the second candidate has the smaller error around the pixel, else 0.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rg32f) readonly uniform image2D errors;
layout(set = 0, binding = 1, r32f) writeonly uniform image2D choice;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(errors);
    if (!IsInside(pixel, size)) return;
    ivec2 begin = WindowBegin(pixel, 4), end = WindowEnd(pixel, 4, size);
    vec2 sums = vec2(0.0f);
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) sums += imageLoad(errors, ivec2(x, y)).xy;
    imageStore(choice, pixel, vec4(sums.y < sums.x ? 1.0f : 0.0f));
}
