// Flip, second step: a picture that flip_rows.comp has filtered, filtered along its columns.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "post/flip.glsl"
#include "shared/flip_kernels.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D colors;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D features;
layout(set = 0, binding = 2, scalar) uniform Kernels { FlipKernels value; } kernels;
layout(set = 0, binding = 3, rgba32f) writeonly uniform image2D labAndEdge;  // the response's length
layout(set = 0, binding = 4, r32f) writeonly uniform image2D point;         // points, likewise

void main() {
    ivec2 size = imageSize(labAndEdge);
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, size))) return;
    vec4 color = vec4(0.0f);
    vec4 edge = vec4(0.0f);  // along x, along y; second derivatives along x, along y
    int colorRadius = int(kernels.value.colorRadius);
    int featureRadius = int(kernels.value.featureRadius);
    int radius = max(colorRadius, featureRadius);
    for (int i = -radius; i <= radius; ++i) {
        ivec2 at = ivec2(pixel.x, clamp(pixel.y + i, 0, size.y - 1));
        if (abs(i) <= colorRadius) color += kernels.value.color[abs(i)] * imageLoad(colors, at);
        if (abs(i) <= featureRadius) {
            vec4 weights = kernels.value.feature[abs(i)];
            vec4 row = imageLoad(features, at);
            edge += vec4(weights.x * row.y, (i < 0 ? -weights.y : weights.y) * row.x, weights.x * row.z,
                         weights.z * row.x);
        }
    }
    vec3 opponent = vec3(color.xy, dot(kernels.value.blueYellow, color.zw));
    vec3 linear = clamp(FlipFromOpponent(opponent), vec3(0.0f), vec3(1.0f));
    imageStore(labAndEdge, pixel, vec4(FlipToHuntLab(linear), length(edge.xy)));
    imageStore(point, pixel, vec4(length(edge.zw)));
}
