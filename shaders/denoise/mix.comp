// One estimate of three, by choices that are averaged around the pixel; and, for blend.comp, the noise that
// the estimate is free of and its squared difference to the mean.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D noise;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D detailed;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D medium;
layout(set = 0, binding = 4, rgba32f) readonly uniform image2D smoothed;
layout(set = 0, binding = 5, rgba32f) readonly uniform image2D choice;
layout(set = 0, binding = 6, rgba32f) writeonly uniform image2D estimate;
layout(set = 0, binding = 7, rg32f) writeonly uniform image2D removed;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean);
    if (!IsInside(pixel, size)) return;
    ivec2 begin = WindowBegin(pixel, 2), end = WindowEnd(pixel, 2, size);
    vec3 sum = vec3(0.0f);
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) sum += imageLoad(choice, ivec2(x, y)).xyz;
    sum /= float((end.x - begin.x + 1) * (end.y - begin.y + 1));
    vec4 mixed = sum.x * imageLoad(detailed, pixel) + sum.y * imageLoad(medium, pixel) +
                 sum.z * imageLoad(smoothed, pixel);
    vec3 weight = ErrorWeight(mixed.xyz);
    vec3 difference = FiniteOr0(imageLoad(mean, pixel).xyz) - mixed.xyz;
    imageStore(estimate, pixel, mixed);
    imageStore(removed, pixel,
               vec4((1.0f - mixed.w) * Sum(imageLoad(noise, pixel).xyz * weight),
                    Sum(difference * difference * weight), 0.0f, 0.0f));
}
