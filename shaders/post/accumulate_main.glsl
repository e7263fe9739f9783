// Accumulate: adds the next sample, or a tile of it, to the exact sums. Includers may define WITH_VARIANCE.
layout(local_size_x = 8, local_size_y = 8) in;

#include "post/exact_planes.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D newSample;

layout(push_constant) uniform Constants {
    uvec2 offset;  // of the new sample in the picture
    uint isFirst;  // of its pixels: the stored contents are undefined
} constants;

// Adds a word and the carry from the words below to a word of each channel, and returns the new carry. The
// plane is read and written only where that changes something: the highest words seldom change.
#define ADD_TO(plane)                                                      \
    {                                                                      \
        uvec4 fromAddend, fromSum;                                         \
        uvec4 change = uaddCarry(addend, carry, fromAddend);               \
        carry = fromAddend;                                                \
        if (isFirst || change != uvec4(0u)) {                              \
            uvec4 before = isFirst ? uvec4(0u) : imageLoad(plane, pixel);  \
            imageStore(plane, pixel, uaddCarry(before, change, fromSum));  \
            carry += fromSum;                                              \
        }                                                                  \
    }

ExactWords words[4];  // of each channel's value

uvec4 Words(int k) {
    return uvec4(WordOf(words[0], k), WordOf(words[1], k), WordOf(words[2], k), WordOf(words[3], k));
}

#ifdef WITH_VARIANCE
// The highest word of channel c, in plane c.
#define ADD_TO_HIGHEST(plane, channel)                                                        \
    {                                                                                         \
        uint change = WordOf(words[channel], kSquareWords - 1) + carry[channel];             \
        if (change != 0u) imageStore(plane, pixel, imageLoad(plane, pixel) + uvec4(0u, 0u, 0u, change)); \
    }
#endif

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(newSample)))) return;
    ivec2 pixel = texel + ivec2(constants.offset);
    bool isFirst = constants.isFirst != 0u;
    uvec4 bits = floatBitsToUint(imageLoad(newSample, texel)), addend;
    uvec4 carry;
    ExactValue values[4];
    for (int c = 0; c < 4; ++c) {
        values[c] = ExactSample(bits[c]);
        words[c] = WordsOf(values[c]);
        carry[c] = words[c].complement & 1u;
    }
    addend = Words(0);
    ADD_TO(sum0)
    addend = Words(1);
    ADD_TO(sum1)
    addend = Words(2);
    ADD_TO(sum2)
    addend = Words(3);
    ADD_TO(sum3)
#ifdef WITH_VARIANCE
    for (int c = 0; c < 3; ++c) words[c] = WordsOf(ExactSquare(values[c]));
    words[3] = WordsOf(ExactSample(0u));
    carry = uvec4(0u);
    addend = Words(0);
    ADD_TO(squares0)
    addend = Words(1);
    ADD_TO(squares1)
    addend = Words(2);
    ADD_TO(squares2)
    addend = Words(3);
    ADD_TO(squares3)
    ADD_TO_HIGHEST(squares0, 0)
    ADD_TO_HIGHEST(squares1, 1)
    ADD_TO_HIGHEST(squares2, 2)
#endif
}
