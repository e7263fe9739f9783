// Writes the variance of a sample without the radiance that the camera sees directly, and in w 1 if that is
// most of the sample's variance, else 0. Edges of lights vary much, and what is fitted does not have them.
//
// For samples that either see a light or find other radiance, the mean square is the sum of those of both
// parts. So the part that is seen adds its own variance, less twice the product of both means. Lights that
// reflect others, too, have both in one sample; then this subtracts too little.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D variance;  // of a sample of the picture
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D seen;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D squares;  // mean of those of the seen samples
layout(set = 0, binding = 4, rgba32f) writeonly uniform image2D ofTarget;

layout(push_constant) uniform Constants {
    uint hasSeen;
    float unbiased;  // n / (n - 1) for n samples
} constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean);
    if (!IsInside(pixel, size)) return;
    vec3 whole = max(FiniteOr0(imageLoad(variance, pixel).xyz), vec3(0.0f)), rest = whole;
    if (constants.hasSeen != 0u) {
        const float kRounding = 4e-6f;  // of a large square from which another is subtracted
        vec3 light = FiniteOr0(imageLoad(seen, pixel).xyz), square = FiniteOr0(imageLoad(squares, pixel).xyz);
        vec3 others = FiniteOr0(imageLoad(mean, pixel).xyz) - light;
        vec3 added = square - light * light - 2.0f * light * others;
        rest -= constants.unbiased * mix(vec3(0.0f), added + kRounding * square,
                                         greaterThan(added, kRounding * square));
    }
    rest = max(rest, vec3(0.0f));
    vec3 weight = ErrorWeight(FiniteOr0(imageLoad(mean, pixel).xyz));
    bool isMost = 2.0f * Sum(rest * weight) >= Sum(whole * weight);
    imageStore(ofTarget, pixel, vec4(rest, isMost));
}
