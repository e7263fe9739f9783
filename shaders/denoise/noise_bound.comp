// The first guide: the target, and in w the variance that weights use, the mean over channels. It is at least
// its mean among similar surfaces around the pixel, since estimates from few samples are too low where no
// bright sample was found.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D noise;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D albedoFeature;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D normalFeature;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D target;
layout(set = 0, binding = 4, rgba32f) writeonly uniform image2D guide;

layout(push_constant) uniform Constants { int radius; } constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(noise);
    if (!IsInside(pixel, size)) return;
    ivec2 begin = WindowBegin(pixel, constants.radius), end = WindowEnd(pixel, constants.radius, size);
    vec4 albedo = imageLoad(albedoFeature, pixel), normal = imageLoad(normalFeature, pixel);
    vec3 sum = vec3(0.0f);
    float weights = 0.0f;
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) {
            ivec2 other = ivec2(x, y);
            float weight = exp(-FeatureDistance(albedo, imageLoad(albedoFeature, other), normal,
                                                imageLoad(normalFeature, other)));
            sum += weight * imageLoad(noise, other).xyz;
            weights += weight;
        }
    vec3 value = imageLoad(target, pixel).xyz;
    float variance = Sum(max(sum / weights, imageLoad(noise, pixel).xyz)) / 3.0f;
    imageStore(guide, pixel, vec4(value, variance + LeastVariance(value)));
}
