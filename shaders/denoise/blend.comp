// Writes the mean, shrunk towards the estimate as James and Stein (1961) do: by the share of the squared
// difference around the pixel that noise explains. The rest is an error of the estimate. Radiance that the
// camera sees directly is replaced by the mean over further samples.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D estimate;
layout(set = 0, binding = 2, rg32f) readonly uniform image2D removed;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D seen;
layout(set = 0, binding = 4, rgba32f) readonly uniform image2D seenByAll;
layout(set = 0, binding = 5, rgba32f) writeonly uniform image2D denoised;

layout(push_constant) uniform Constants {
    float margin;   // factor >= 1 on the removed noise, for the randomness of sums over 9 x 9 pixels
    uint isSingle;  // 1 for a single sample, whose noise is a guess
} constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean);
    if (!IsInside(pixel, size)) return;
    ivec2 begin = WindowBegin(pixel, 4), end = WindowEnd(pixel, 4, size);
    vec2 sums = vec2(0.0f);
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) sums += imageLoad(removed, ivec2(x, y)).xy;
    float kept = sums.x > 0.0f ? clamp(1.0f - constants.margin * sums.x / sums.y, 0.0f, 1.0f) : 1.0f;
    if (constants.isSingle != 0u) kept = 0.0f;
    vec4 value = imageLoad(mean, pixel);
    vec3 blended = kept * FiniteOr0(value.xyz) + (1.0f - kept) * imageLoad(estimate, pixel).xyz;
    blended += FiniteOr0(imageLoad(seenByAll, pixel).xyz) - FiniteOr0(imageLoad(seen, pixel).xyz);
    float alpha = FiniteOr0(value.www).x;
    imageStore(denoised, pixel, vec4(blended, alpha));
}
