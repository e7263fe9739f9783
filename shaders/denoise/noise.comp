// Writes the variance of the mean in each channel: that of a sample over their count n, times what
// half_error.comp has found around the pixel; of a single sample, the variance among similar surfaces around.
//
// Suppose that the squared error is c n^-(1 + r). Each half then has c (n / 2)^-(1 + r), so that the halves
// estimate 2^r times the error. Divided by variance / n, this is (n / 2)^-r, which gives r.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D target;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D variance;  // denoise/variance.comp
layout(set = 0, binding = 2, rg32f) readonly uniform image2D errors;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D albedoFeature;
layout(set = 0, binding = 4, rgba32f) readonly uniform image2D normalFeature;
layout(set = 0, binding = 5, rgba32f) writeonly uniform image2D noise;

layout(push_constant) uniform Constants {
    float perSample;        // 1 / count of samples; 1 for a single one
    float samplesOfHalf;    // of the smaller half; 0: there are no halves
} constants;

float Ratio(ivec2 pixel, ivec2 size) {
    if (constants.samplesOfHalf <= 0.0f) return 1.0f;
    ivec2 begin = WindowBegin(pixel, 7), end = WindowEnd(pixel, 7, size);
    vec2 sums = vec2(0.0f);
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) sums += imageLoad(errors, ivec2(x, y)).xy;
    if (!(sums.y > 0.0f)) return 0.0f;
    float ratio = min(sums.x / sums.y, 1.0f);
    if (constants.samplesOfHalf <= 1.0f || !(ratio > 0.0f)) return ratio;
    return ratio * exp2(min(log(ratio) / log(constants.samplesOfHalf), 0.0f));
}

vec3 VarianceAround(ivec2 pixel, ivec2 size) {
    ivec2 begin = WindowBegin(pixel, 3), end = WindowEnd(pixel, 3, size);
    vec4 albedo = imageLoad(albedoFeature, pixel), normal = imageLoad(normalFeature, pixel);
    vec3 center = FiniteOr0(imageLoad(target, pixel).xyz);
    vec3 sum = vec3(0.0f), squares = vec3(0.0f);
    float weights = 0.0f;
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) {
            ivec2 other = ivec2(x, y);
            float weight = exp(-FeatureDistance(albedo, imageLoad(albedoFeature, other), normal,
                                                imageLoad(normalFeature, other)));
            vec3 value = FiniteOr0(imageLoad(target, other).xyz) - center;
            sum += weight * value;
            squares += weight * value * value;
            weights += weight;
        }
    sum /= weights;
    return max(squares / weights - sum * sum, vec3(0.0f));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(target);
    if (!IsInside(pixel, size)) return;
    vec3 result;
    if (constants.perSample >= 1.0f)
        result = VarianceAround(pixel, size);
    else
        result = imageLoad(variance, pixel).xyz * constants.perSample * Ratio(pixel, size);
    imageStore(noise, pixel, vec4(result, 0.0f));
}
