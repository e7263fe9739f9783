// Writes what is fitted, and features of surfaces: finite means of albedo and normal, and in w four times the
// squared gradient. The smaller of both one-sided differences is taken in each direction, so that an edge is
// no gradient.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D albedo;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D normal;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D seen;
layout(set = 0, binding = 4, rgba32f) writeonly uniform image2D albedoFeature;
layout(set = 0, binding = 5, rgba32f) writeonly uniform image2D normalFeature;
layout(set = 0, binding = 6, rgba32f) writeonly uniform image2D target;

layout(push_constant) uniform Constants { uint hasSeen; } constants;

float SquaredGradient(vec3 center, vec3 left, vec3 right, vec3 above, vec3 below) {
    vec3 x = min(abs(right - center), abs(center - left)), y = min(abs(below - center), abs(center - above));
    return 4.0f * (dot(x, x) + dot(y, y));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(albedo);
    if (!IsInside(pixel, size)) return;
    ivec2 low = WindowBegin(pixel, 1), high = WindowEnd(pixel, 1, size);
    ivec2 left = ivec2(low.x, pixel.y), right = ivec2(high.x, pixel.y);
    ivec2 above = ivec2(pixel.x, low.y), below = ivec2(pixel.x, high.y);
#define FEATURE_OF(image, feature)                                                                       \
    {                                                                                                    \
        vec3 center = FiniteOr0(imageLoad(image, pixel).xyz);                                            \
        float gradient = SquaredGradient(                                                                \
            center, FiniteOr0(imageLoad(image, left).xyz), FiniteOr0(imageLoad(image, right).xyz),       \
            FiniteOr0(imageLoad(image, above).xyz), FiniteOr0(imageLoad(image, below).xyz));             \
        imageStore(feature, pixel, vec4(center, gradient));                                              \
    }
    FEATURE_OF(albedo, albedoFeature)
    FEATURE_OF(normal, normalFeature)
    vec3 value = FiniteOr0(imageLoad(mean, pixel).xyz);
    if (constants.hasSeen != 0u) value -= FiniteOr0(imageLoad(seen, pixel).xyz);
    imageStore(target, pixel, vec4(value, 0.0f));
}
