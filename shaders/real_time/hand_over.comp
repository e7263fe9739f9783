// HandOver, second half: both pictures, by the weights of the blocks around a pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_image_load_formatted : require
#include "real_time/hand_over.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) readonly uniform image2D picture;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D reference;
layout(set = 0, binding = 2, r32f) readonly uniform image2D weights;
layout(set = 0, binding = 3, rgba32f) writeonly uniform image2D shown;

float WeightAt(ivec2 block) { return imageLoad(weights, clamp(block, ivec2(0), imageSize(weights) - 1)).x; }

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(shown)))) return;
    vec2 place = (vec2(pixel) + 0.5f) / float(kBlock) - 0.5f;
    ivec2 first = ivec2(floor(place));
    vec2 part = place - vec2(first);
    float above = mix(WeightAt(first), WeightAt(first + ivec2(1, 0)), part.x);
    float below = mix(WeightAt(first + ivec2(0, 1)), WeightAt(first + ivec2(1, 1)), part.x);
    float weight = mix(above, below, part.y);
    vec4 value = vec4(imageLoad(picture, pixel).xyz, 1.0f);
    // The reference is undefined where it has no sample
    if (weight > 0.0f && SamplesAt(pixel) >= kFewSamples)
        value = mix(value, imageLoad(reference, pixel), weight);
    imageStore(shown, pixel, value);
}
