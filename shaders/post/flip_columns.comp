// Flip, second half: both pictures filtered along their columns, and compared.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "post/flip.glsl"
#include "shared/flip_kernels.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D referenceColors;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D referenceFeatures;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D testColors;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D testFeatures;
layout(set = 0, binding = 4, scalar) uniform Kernels { FlipKernels value; } kernels;
layout(set = 0, binding = 5, r32f) writeonly uniform image2D error;

struct Filtered {
    vec4 color;
    vec4 edge;  // along x, along y; second derivatives along x, along y
};

void AddColor(inout Filtered sums, vec4 row, int tap) { sums.color += kernels.value.color[abs(tap)] * row; }

void AddFeature(inout Filtered sums, vec4 row, int tap) {
    vec4 weights = kernels.value.feature[abs(tap)];
    sums.edge += vec4(weights.x * row.y, (tap < 0 ? -weights.y : weights.y) * row.x, weights.x * row.z,
                      weights.z * row.x);
}

vec3 HuntLabOf(Filtered sums) {
    vec3 opponent = vec3(sums.color.xy, dot(kernels.value.blueYellow, sums.color.zw));
    return FlipToHuntLab(clamp(FlipFromOpponent(opponent), vec3(0.0f), vec3(1.0f)));
}

vec2 FeaturesOf(Filtered sums) { return vec2(length(sums.edge.xy), length(sums.edge.zw)); }

void main() {
    ivec2 size = imageSize(error);
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, size))) return;
    Filtered reference, test;
    reference.color = reference.edge = test.color = test.edge = vec4(0.0f);
    int colorRadius = int(kernels.value.colorRadius);
    int featureRadius = int(kernels.value.featureRadius);
    int radius = max(colorRadius, featureRadius);
    for (int i = -radius; i <= radius; i++) {
        ivec2 at = ivec2(pixel.x, clamp(pixel.y + i, 0, size.y - 1));
        if (abs(i) <= colorRadius) {
            AddColor(reference, imageLoad(referenceColors, at), i);
            AddColor(test, imageLoad(testColors, at), i);
        }
        if (abs(i) <= featureRadius) {
            AddFeature(reference, imageLoad(referenceFeatures, at), i);
            AddFeature(test, imageLoad(testFeatures, at), i);
        }
    }
    float colorError = FlipColorError(HuntLabOf(reference), HuntLabOf(test));
    float featureError = FlipFeatureError(FeaturesOf(reference), FeaturesOf(test));
    // (3.3)
    float value = colorError > 0.0f ? pow(colorError, 1.0f - featureError) : 0.0f;
    imageStore(error, pixel, vec4(value));
}
