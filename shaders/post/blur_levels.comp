// BlurLevels: the levels of shared/blur_levels.h. A texel is the mean of its square of the picture and a
// margin of half a texel, by 4 x 4 samples; color is multiplied by alpha.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/blur_levels.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D picture;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D levels;

void main() {
    uvec2 texel = gl_GlobalInvocationID.xy;
    uvec2 size = uvec2(textureSize(picture, 0));
    uint level = 1u;
    while (level < kBlurLevels && texel.y >= BlurRow(size.y, level + 1u)) ++level;
    texel.y -= BlurRow(size.y, level);
    if (texel.x >= BlurSize(size.x, level) || texel.y >= BlurSize(size.y, level)) return;
    float scale = float(1u << level);
    vec4 sum = vec4(0.0f);
    for (uint i = 0u; i < 16u; ++i) {
        vec2 offset = (vec2(float(i & 3u), float(i >> 2u)) - 1.5f) * 0.5f;
        vec2 place = (vec2(texel) + 0.5f + offset) * scale / vec2(size);
        // The color is multiplied by alpha, so that a sample at an edge has the color of the surface.
        vec4 value = textureLod(picture, clamp(place, vec2(0.0f), vec2(1.0f)), 0.0f);
        sum += vec4(value.xyz * value.w, value.w);
    }
    imageStore(levels, ivec2(gl_GlobalInvocationID.xy), sum / 16.0f);
}
