// Accumulate: takes the next sample, or a tile of it, into the running mean. Includers may define
// WITH_VARIANCE.
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D newSample;
layout(set = 0, binding = 1, rgba32f) uniform image2D mean;
#ifdef WITH_VARIANCE
layout(set = 0, binding = 2, rgba32f) uniform image2D variance;
#endif

layout(push_constant) uniform Constants {
    uvec2 offset;      // of the new sample in the picture
    uint sampleCount;  // of its pixels in the mean so far
} constants;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(newSample)))) return;
    ivec2 pixel = texel + ivec2(constants.offset);
    vec4 value = imageLoad(newSample, texel);
    // What is stored before the first sample is undefined, possibly NaN: not read into the arithmetic
    bool isFirst = constants.sampleCount == 0u;
    float count = float(constants.sampleCount + 1u);
    vec4 oldMean = isFirst ? vec4(0.0f) : imageLoad(mean, pixel);
    vec4 delta = value - oldMean;
    vec4 newMean = isFirst ? value : oldMean + delta / count;
    imageStore(mean, pixel, newMean);
#ifdef WITH_VARIANCE
    vec4 squares = constants.sampleCount < 2u ? vec4(0.0f) : imageLoad(variance, pixel) * (count - 2.0f);
    vec4 newVariance = isFirst ? vec4(0.0f) : (squares + delta * (value - newMean)) / (count - 1.0f);
    imageStore(variance, pixel, newVariance);
#endif
}
