// HandOver, first half: the weight of the reference in each block of pixels, by the errors of both pictures.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_image_load_formatted : require
#define WITH_VARIANCE
#include "post/pixel_sums.glsl"
#include "real_time/hand_over.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) readonly uniform image2D picture;
layout(set = 0, binding = 1, r32f) writeonly uniform image2D weights;

const int kChannel = 1;  // green, which has most of the luminance
const int kStep = 2;     // every second pixel of every second row says enough
// The relative squared error that the picture has at least, since its filter is not free of bias.
const float kLeastError = 1e-4f;
// The variance of n samples is multiplied by 1 + kUncertainty / n: fireflies that have not come yet are not
// in it. By measurement, the blend is then hardly worse than the better one of both pictures.
const float kUncertainty = 16.0f;

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy), size = imageSize(picture);
    if (any(greaterThanEqual(block, imageSize(weights)))) return;
    float difference = 0.0f, noise = 0.0f, count = 0.0f;
    for (int y = 0; y < kBlock; y += kStep)
        for (int x = 0; x < kBlock; x += kStep) {
            ivec2 pixel = kBlock * block + ivec2(x, y);
            if (any(greaterThanEqual(pixel, size))) continue;
            uint samples = SamplesAt(pixel);
            if (samples < kFewSamples) {
                imageStore(weights, block, vec4(0.0f));
                return;
            }
            PixelSums sums = SumsOf(pixel);
            float mean = uintBitsToFloat(MeanOfCount(SumOf(sums, kChannel), samples));
            float variance = uintBitsToFloat(VarianceOf(sums, kChannel, samples)) / float(samples);
            variance *= 1.0f + kUncertainty / float(samples);
            float shown = imageLoad(picture, pixel)[kChannel];
            float scale = 1.0f / (shown * shown + 0.01f);
            difference += scale * (mean - shown) * (mean - shown);
            noise += scale * variance;
            count += 1.0f;
        }
    // The squared difference is expected to be the sum of both squared errors
    float error = max(difference - noise, kLeastError * count);
    imageStore(weights, block, vec4(error / (error + noise)));
}
