// Flip, first step: a picture filtered along its rows. Pixels beyond the border repeat the border.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "post/flip.glsl"
#include "shared/flip_kernels.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2D picture;  // sRGB-encoded
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D colors;    // filtered by FlipKernels::color
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D features;  // filtered by FlipKernels::feature
layout(set = 0, binding = 3, scalar) uniform Kernels { FlipKernels value; } kernels;

vec3 OpponentAt(ivec2 pixel) {
    vec3 encoded = clamp(texelFetch(picture, pixel, 0).xyz, vec3(0.0f), vec3(1.0f));
    return FlipToOpponent(SrgbDecode(encoded));
}

void main() {
    ivec2 size = imageSize(colors);
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, size))) return;
    vec4 colorSum = vec4(0.0f);
    vec4 featureSum = vec4(0.0f);
    int colorRadius = int(kernels.value.colorRadius);
    int featureRadius = int(kernels.value.featureRadius);
    int radius = max(colorRadius, featureRadius);
    for (int i = -radius; i <= radius; ++i) {
        vec3 c = OpponentAt(ivec2(clamp(pixel.x + i, 0, size.x - 1), pixel.y));
        if (abs(i) <= colorRadius) colorSum += kernels.value.color[abs(i)] * c.xyzz;
        vec4 weights = kernels.value.feature[abs(i)];
        if (i < 0) weights.y = -weights.y;
        if (abs(i) <= featureRadius) featureSum += weights * ((c.x + 16.0f) / 116.0f);
    }
    imageStore(colors, pixel, colorSum);
    imageStore(features, pixel, featureSum);
}
