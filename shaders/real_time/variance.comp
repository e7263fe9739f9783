// EstimateVariance: the variance of each pixel's mean, from the moments of its samples and of its neighbors'.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/color.glsl"
#include "real_time/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba16f) readonly uniform image2D mean;  // w: number of samples
layout(set = 0, binding = 1, r16f) readonly uniform image2D deviation;
layout(set = 0, binding = 2, rg32ui) readonly uniform uimage2D surfaces;
layout(set = 0, binding = 3, rgba16f) readonly uniform image2D albedo;  // w: dullness
layout(set = 0, binding = 4, rgba16f) writeonly uniform image2D guided;  // the mean; w: its deviation

const float kUncertainty = 6.0f;  // the variance of n samples is multiplied by 1 + kUncertainty / n
const float kLeastNoise = 0.1f;   // and in a mirror by this
const float kFewSamples = 4.0f;  // fewer say little about their variance
// A pixel is a firefly if it is brighter than the brightest of its neighbors by the first factor (a rank
// condition as in Hardie and Barner 1994, "Rank Conditioned Rank Selection Filters for Signal Restoration").
// Its deviation is then its luminance times the second one: the filter distributes its light around it.
const float kFirefly = 2.0f;
const float kFireflyNoise = 3.0f;
const float kLeastNeighbors = 3.0f;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean);
    if (!IsInside(pixel, size)) return;
    vec4 own = imageLoad(mean, pixel);
    uvec2 texel = imageLoad(surfaces, pixel).xy;
    uint number = NumberOf(texel);
    vec3 normal = NormalOf(texel);
    if (number == kNothingHit) {
        imageStore(guided, pixel, vec4(own.xyz, 0.0f));
        return;
    }
    bool areFew = own.w < kFewSamples;
    int radius = areFew ? 3 : 1;
    float brightest = 0.0f, neighbors = 0.0f;
    float sum = 0.0f, squares = 0.0f, over = 0.0f, weights = 0.0f;
    for (int y = -radius; y <= radius; ++y)
        for (int x = -radius; x <= radius; ++x) {
            ivec2 at = pixel + ivec2(x, y);
            if (!IsInside(at, size)) continue;
            uvec2 other = imageLoad(surfaces, at).xy;
            if (NumberOf(other) != number || dot(NormalOf(other), normal) < 0.9f) continue;
            vec4 value = imageLoad(mean, at);
            float luminance = Luminance(value.xyz), deviated = imageLoad(deviation, at).x;
            float variance = deviated * deviated;
            if (max(abs(x), abs(y)) == 1) {
                brightest = max(brightest, luminance);
                neighbors += 1.0f;
            }
            float weight = exp2(-float(abs(x) + abs(y)) / float(radius));
            sum += weight * luminance;
            squares += weight * (variance + luminance * luminance);
            // The variance of one sample exceeds that among n by a factor of n / (n - 1)
            over += weight * variance * value.w / max(value.w - 1.0f, 1.0f);
            weights += weight;
        }
    float average = sum / weights;
    float ofSample = areFew ? max(squares / weights - average * average, 0.0f) : over / weights;
    // No guide shows the edges of what a mirror shows: there, less counts as noise
    float dullness = imageLoad(albedo, pixel).w;
    ofSample *= mix(kLeastNoise, 1.0f, dullness);
    // The variance of few samples is uncertain itself, and rather too small than too large
    ofSample *= 1.0f + kUncertainty / own.w;
    float ofMean = sqrt(ofSample / own.w), ownLuminance = Luminance(own.xyz);
    if (neighbors >= kLeastNeighbors && ownLuminance > kFirefly * brightest)
        ofMean = max(ofMean, kFireflyNoise * ownLuminance);
    imageStore(guided, pixel, ToHalf(vec4(own.xyz, ofMean), kToNearest));
}
