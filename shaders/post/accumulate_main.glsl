// Accumulate: adds the next samples, or a tile of one, to the exact sums. Variants define WITH_VARIANCE, and
// LISTED: the samples are of the pixels of a list.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef LISTED
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#endif
layout(local_size_x = 8, local_size_y = 8) in;

#include "post/exact_planes.glsl"

#ifdef LISTED
#include "scene/pixel_list.glsl"
#endif

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D newSamples;

layout(push_constant) uniform Constants {
    uvec2 offset;  // position of the new samples in the picture
    uint isFirst;  // 1 for the first sample of its pixels: the stored contents are undefined
    uint sampleCount;
    // rows of each sample, which lie below each other; in each tile where there are more rows
    uint sampleRows;
#ifdef LISTED
    uint listWidth;      // texels: of a tile of the new samples, as sampleRows
    uint listCount;      // texels of a tile that are of a pixel
    uvec2 pictureSize;   // size of a tile of the sums
    uvec2 list;          // address
#endif
} constants;

// Adds a word and the carry from the words below to a word of each channel, and leaves the new carry. The
// plane is read and written only where that changes something: the highest words seldom change.
#define ADD_TO(plane, addend)                                              \
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

// The sums of the new samples.
uvec4 sums[4];
#ifdef WITH_VARIANCE
uvec4 squares[kSquareWords];
#endif

ExactWords words[4];  // words of each channel's value

uvec4 Words(int k) {
    return uvec4(WordOf(words[0], k), WordOf(words[1], k), WordOf(words[2], k), WordOf(words[3], k));
}

// Returns the sum of three words, of which `carry` is at most 1; leaves the new carry.
uvec4 AddWords(uvec4 a, uvec4 b, inout uvec4 carry) {
    uvec4 first, second;
    uvec4 sum = uaddCarry(uaddCarry(a, b, first), carry, second);
    carry = first + second;
    return sum;
}

void AddSample(uvec4 bits) {
    uvec4 carry;
    ExactValue values[4];
    for (int c = 0; c < 4; ++c) {
        values[c] = ExactSample(bits[c]);
        words[c] = WordsOf(values[c]);
        carry[c] = words[c].complement & 1u;
    }
    for (int k = 0; k < kSumWords; ++k) sums[k] = AddWords(sums[k], Words(k), carry);
#ifdef WITH_VARIANCE
    for (int c = 0; c < 3; ++c) words[c] = WordsOf(ExactSquare(values[c]));
    words[3] = WordsOf(ExactSample(0u));
    carry = uvec4(0u);
    for (int k = 0; k < kSquareWords; ++k) squares[k] = AddWords(squares[k], Words(k), carry);
#endif
}

#ifdef WITH_VARIANCE
// The highest word of channel c, in plane c.
#define ADD_TO_HIGHEST(plane, channel) \
    { \
        uint change = squares[kSquareWords - 1][channel] + carry[channel]; \
        if (change != 0u)                                                          \
            imageStore(plane, pixel, imageLoad(plane, pixel) + uvec4(0u, 0u, 0u, change)); \
    }
#endif

void main() {
    uvec2 texel = gl_GlobalInvocationID.xy;
    uvec2 size = uvec2(imageSize(newSamples));
    size.y /= constants.sampleCount;
    if (any(greaterThanEqual(texel, size))) return;
#ifdef LISTED
    uvec2 listSize = uvec2(constants.listWidth, constants.sampleRows);
    uvec2 inTile = texel % listSize;
    uint entry = inTile.y * constants.listWidth + inTile.x;
    if (entry >= constants.listCount) return;
    uvec2 inPicture = PixelOf(PixelListStream(constants.list).at[entry]);
    ivec2 pixel = ivec2(inPicture + texel / listSize * constants.pictureSize);
#else
    ivec2 pixel = ivec2(texel + constants.offset);
#endif
    bool isFirst = constants.isFirst != 0u;
    for (int k = 0; k < kSumWords; ++k) sums[k] = uvec4(0u);
#ifdef WITH_VARIANCE
    for (int k = 0; k < kSquareWords; ++k) squares[k] = uvec4(0u);
#endif
    uint tile = texel.y / constants.sampleRows;
    uint row = texel.y + tile * (constants.sampleCount - 1u) * constants.sampleRows;
    for (uint i = 0u; i < constants.sampleCount; ++i, row += constants.sampleRows)
        AddSample(floatBitsToUint(imageLoad(newSamples, ivec2(texel.x, row))));
    uvec4 carry = uvec4(0u);
    ADD_TO(sum0, sums[0])
    ADD_TO(sum1, sums[1])
    ADD_TO(sum2, sums[2])
    ADD_TO(sum3, sums[3])
#ifdef WITH_VARIANCE
    carry = uvec4(0u);
    ADD_TO(squares0, squares[0])
    ADD_TO(squares1, squares[1])
    ADD_TO(squares2, squares[2])
    ADD_TO(squares3, squares[3])
    ADD_TO_HIGHEST(squares0, 0)
    ADD_TO_HIGHEST(squares1, 1)
    ADD_TO_HIGHEST(squares2, 2)
#endif
}
