// Mixes three estimates by choices that are averaged around the pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D detailed;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D medium;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D smoothed;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D choice;
layout(set = 0, binding = 4, rgba32f) writeonly uniform image2D estimate;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(choice);
    if (!IsInside(pixel, size)) return;
    ivec2 begin = WindowBegin(pixel, 2), end = WindowEnd(pixel, 2, size);
    vec3 sum = vec3(0.0f);
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) sum += imageLoad(choice, ivec2(x, y)).xyz;
    sum /= float((end.x - begin.x + 1) * (end.y - begin.y + 1));
    imageStore(estimate, pixel,
               sum.x * imageLoad(detailed, pixel) + sum.y * imageLoad(medium, pixel) +
                   sum.z * imageLoad(smoothed, pixel));
}
