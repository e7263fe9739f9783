// EstimateVariance: the variance of each pixel's mean, from the moments of its samples and of its neighbors'.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/color.glsl"
#include "real_time/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;  // w: number of samples
layout(set = 0, binding = 1, r32f) readonly uniform image2D square;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D surfaces;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D albedo;  // w: dullness
layout(set = 0, binding = 4, rgba32f) writeonly uniform image2D guided;  // the mean; w: its variance

const float kUncertainty = 6.0f;  // samples
const float kLeastNoise = 0.1f;
const float kFewSamples = 4.0f;  // fewer say little about their variance

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean);
    if (!IsInside(pixel, size)) return;
    vec4 own = imageLoad(mean, pixel);
    vec4 texel = imageLoad(surfaces, pixel);
    vec3 normal = FromOctahedron(texel.xy);
    if (texel.w == 0.0f) {
        imageStore(guided, pixel, vec4(own.xyz, 0.0f));
        return;
    }
    bool areFew = own.w < kFewSamples;
    int radius = areFew ? 3 : 1;
    float sum = 0.0f, squares = 0.0f, over = 0.0f, weights = 0.0f;
    for (int y = -radius; y <= radius; ++y)
        for (int x = -radius; x <= radius; ++x) {
            ivec2 at = pixel + ivec2(x, y);
            if (!IsInside(at, size)) continue;
            vec4 other = imageLoad(surfaces, at);
            if (other.w != texel.w || dot(FromOctahedron(other.xy), normal) < 0.9f) continue;
            vec4 value = imageLoad(mean, at);
            float luminance = Luminance(value.xyz), squared = imageLoad(square, at).x;
            float weight = exp2(-float(abs(x) + abs(y)) / float(radius));
            sum += weight * luminance;
            squares += weight * squared;
            // The variance of one sample exceeds that among n by a factor of n / (n - 1)
            over += weight * max(squared - luminance * luminance, 0.0f) * value.w / max(value.w - 1.0f, 1.0f);
            weights += weight;
        }
    float average = sum / weights;
    float ofSample = areFew ? max(squares / weights - average * average, 0.0f) : over / weights;
    // No guide shows the edges of what a mirror shows: there, less counts as noise
    float dullness = imageLoad(albedo, pixel).w;
    ofSample *= mix(kLeastNoise, 1.0f, dullness);
    // The variance of few samples is uncertain itself, and rather too small than too large
    ofSample *= 1.0f + kUncertainty / own.w;
    imageStore(guided, pixel, vec4(own.xyz, ofSample / own.w));
}
