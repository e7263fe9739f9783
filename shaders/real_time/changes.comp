// FindChanges: compares the samples of a frame with the means of those before, in blocks of pixels, to find
// where light has changed. A block's texel: the sum of the differences, of their squares and of the larger
// ones, over pixels with a history.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/color.glsl"
#include "real_time/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;  // kChangeBlock

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D radiance;
layout(set = 0, binding = 1, rgba16f) readonly uniform image2D albedo;
layout(set = 0, binding = 2, rg32ui) readonly uniform uimage2D surfaces;
layout(set = 0, binding = 3, rgba16f) readonly uniform image2D motion;
layout(set = 0, binding = 4, rg32ui) readonly uniform uimage2D surfacesBefore;
layout(set = 0, binding = 5, rgba16f) readonly uniform image2D meanBefore;  // w: number of samples
layout(set = 0, binding = 6, rgba32f) writeonly uniform image2D changes;

shared vec3 parts[64];

// Returns the luminance of the sample and of its history; of both 0 if there is none.
vec2 ValuesOf(ivec2 pixel) {
    vec4 moved = imageLoad(motion, pixel);
    uint number = NumberOf(imageLoad(surfaces, pixel).xy);
    ivec2 before = ivec2(floor(vec2(pixel) + 0.5f + ShiftOf(moved)));
    if (moved.w == 0.0f || number == kNothingHit) return vec2(0.0f);
    if (!IsInside(before, imageSize(meanBefore))) return vec2(0.0f);
    vec4 mean = imageLoad(meanBefore, before);
    if (NumberOf(imageLoad(surfacesBefore, before).xy) != number || mean.w < 2.0f) return vec2(0.0f);
    return vec2(Luminance(LightOf(imageLoad(radiance, pixel), imageLoad(albedo, pixel))),
                Luminance(mean.xyz));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    vec2 values = IsInside(pixel, imageSize(radiance)) && IsInside(pixel, imageSize(motion)) ? ValuesOf(pixel)
                                                                                          : vec2(0.0f);
    float difference = values.x - values.y;
    uint index = gl_LocalInvocationIndex;
    parts[index] = vec3(difference, difference * difference, max(values.x, values.y));
    for (uint count = 32u; count > 0u; count >>= 1) {
        barrier();
        if (index < count) parts[index] += parts[index + count];
    }
    if (index == 0u) imageStore(changes, ivec2(gl_WorkGroupID.xy), vec4(parts[0], 0.0f));
}
