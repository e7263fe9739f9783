// Draws a small picture of a texture of the scene into a cell of the thumbnails: each pixel is the mean of
// texels below it, at most kMostSteps a side, from a level that is not much finer.
#version 460
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
#include "core/color.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba8) uniform writeonly image2D thumbnails;
layout(set = 1, binding = 0) uniform sampler2D textures[];

layout(push_constant, scalar) uniform Constants {
    uvec2 corner;  // of the cell
    uvec2 size;    // of the picture, pixels
    uint slot;
    uint isSrgb;  // texels are decoded when they are read
} constants;

const int kMostSteps = 16;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= constants.size.x || pixel.y >= constants.size.y) return;
    vec2 size = vec2(constants.size);
    int width = int(constants.size.x), level = 0;
    int last = textureQueryLevels(textures[constants.slot]) - 1;
    while (level < last && textureSize(textures[constants.slot], level + 1).x >= width) ++level;
    vec2 extent = vec2(textureSize(textures[constants.slot], level));
    vec2 from = vec2(pixel) / size * extent, reach = extent / size;
    ivec2 steps = clamp(ivec2(ceil(reach)), ivec2(1), ivec2(kMostSteps));
    vec3 sum = vec3(0.0f);
    for (int y = 0; y < steps.y; ++y)
        for (int x = 0; x < steps.x; ++x) {
            vec2 at = from + (vec2(x, y) + 0.5f) / vec2(steps) * reach;
            sum += texelFetch(textures[constants.slot], min(ivec2(at), ivec2(extent) - 1), level).xyz;
        }
    vec3 mean = sum / float(steps.x * steps.y);
    if (constants.isSrgb != 0u) mean = SrgbEncode(mean);
    imageStore(thumbnails, ivec2(constants.corner + pixel), vec4(mean, 1.0f));
}
