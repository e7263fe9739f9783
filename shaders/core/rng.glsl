// Random numbers as functions of (seed, pixel, sample index, dimension) and of nothing else: no state is kept
// between samples, so a render can stop, resume or be split at any sample index and get the same numbers.
//
//     Sampler rng = StartPixelSample(pixel, sampleIndex, seed);
//     vec2 film = Get2D(rng);       // dimensions 0 and 1
//     float choice = Get1D(rng);    // dimension 2
//     vec3 u = Get3D(rng);          // dimensions 3 to 5
//
// Values are in [0, 1) with 24 bits: 1.0 never occurs, 0.0 does. Get1D advances `dimension` by 1, Get2D by 2,
// Get3D by 3.
// The numbers drawn depend on the value of `dimension` at the call, so a caller that sets it to a fixed base
// at each bounce gets the same dimension for the same decision on every path; two draws at the same dimension
// of one sample return the same numbers. Pixel coordinates are below 65536. All 2^32 sample indices, seeds
// and dimensions work.
//
// Kinds, chosen when the pipeline is created (shared/choice.h):
//
// Sobol: shuffled, Owen-scrambled, padded (0,2)-sequences. Every draw is a sequence of its own over the
// sample index, independent of other draws and pixels; each aligned block of 2^k samples of a pixel is a
// (0,k,2)-net, of Get3D a (1,k,3)-net. Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4). The
// two draws of a pair are of one sequence (Get3DOfPair).
//
// Pcg: PCG4D, independent numbers. Jarzynski and Olano 2020, "Hash Functions for GPU Rendering", JCGT 9(3).
//
// Tea: the Tiny Encryption Algorithm with 8 rounds, independent numbers. Zafar, Olano and Curtis 2010, "GPU
// Random Numbers via the Tiny Encryption Algorithm", HPG.
#ifndef RAYGRAPH_CORE_RNG_GLSL
#define RAYGRAPH_CORE_RNG_GLSL

#include "core/option.h"
#include "shared/mix_bits.h"
#include "shared/choice.h"

#ifdef __cplusplus
namespace raygraph::shading {
using gpu::MixBits;
}
#endif

SHADING_BEGIN

OPTION(SamplerKind, SamplerKind, 0, Sobol)

struct Sampler {
    uint pixelSeed;  // one-to-one with the pixel for a given seed, and with the seed for a given pixel
    uint index;      // sample index; for Sobol with its bits reversed, as the scrambling needs it
    uint dimension;  // dimension of the next draw
};

// Returns the top 24 bits as a float in [0, 1). Through int: that conversion is one instruction on CPUs.
INLINE float BitsToUnit(uint bits) {
    return float(int(bits >> 8u)) * 5.9604644775390625e-8f;
}

// Nested uniform (Owen) scrambling of a number whose bits are reversed: each bit is flipped by a hash of the
// bits below it and the seed. Laine-Karras construction with the constants of N. Vegdahl, "Building a Better
// LK Hash" (2021, revised).
INLINE uint OwenScrambleReversed(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

// Returns dimension 2 of Sobol's sequence at `index`, bits reversed. Its generator matrix is Pascal's
// triangle modulo 2, which factors into one masked shift-and-xor for each bit of the bit number (Ahmed 2024,
// "An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and Compact"); dimension 1 reversed is the
// index itself.
INLINE uint SobolSecondReversed(uint index) {
    index ^= index >> 16u;
    index ^= (index >> 8u) & 0x00ff00ffu;
    index ^= (index >> 4u) & 0x0f0f0f0fu;
    index ^= (index >> 2u) & 0x33333333u;
    index ^= (index >> 1u) & 0x55555555u;
    return index;
}

// Returns a third dimension, with which blocks of 2^k points are (1,k,3)-nets. The index is read as a
// polynomial over the field of two elements, and its digits in the base of another polynomial are written
// lowest first (S. Tezuka 1993, "Polynomial Arithmetic Analogue of Halton Sequences"). Dimension 2 is that of
// x + 1; this is that of x^2 + x + 1, whose digits have two bits. Its powers by 2^n have three terms, so that
// each step divides all parts by one: by x^16 + x^8 + 1, x^8 + x^4 + 1, ...
INLINE uint SobolThirdReversed(uint index) {
    index ^= ((index >> 8u) & 0x00ffff00u) ^ ((index >> 16u) & 0x000000ffu) ^ (index >> 24u);
    index ^= ((index >> 4u) & 0x0ff00ff0u) ^ ((index >> 8u) & 0x000f000fu) ^ ((index >> 12u) & 0x000f000fu);
    index ^= ((index >> 2u) & 0x3c3c3c3cu) ^ ((index >> 4u) & 0x03030303u) ^ ((index >> 6u) & 0x03030303u);
    index ^= ((index >> 1u) & 0x66666666u) ^ ((index >> 2u) & 0x11111111u) ^ ((index >> 3u) & 0x11111111u);
    return index;
}

// Returns another third dimension, of x^3 + x + 1: blocks of 2^k points are (2,k,3)-nets. As above, but that
// the middle term of what a step divides by is so near to the first that a part of the quotient is divided
// again.
INLINE uint SobolThirdOfPairReversed(uint index) {
    uint quotient = index >> 24u;
    index ^= (quotient << 8u) ^ quotient;
    quotient = index & 0x00fff000u;
    quotient ^= (quotient >> 8u) & 0x0000f000u;
    index = (index & 0xff000fffu) ^ quotient ^ ((quotient >> 8u) & 0x00000ff0u) ^ (quotient >> 12u);
    quotient = index & 0xc0fc0fc0u;
    quotient ^= (quotient >> 4u) & 0x000c00c0u;
    index = (index & 0x3f03f03fu) ^ quotient ^ ((quotient >> 4u) & 0x0c03c03cu) ^ (quotient >> 6u);
    quotient = index & 0x38e38e38u;
    quotient ^= (quotient >> 2u) & 0x08208208u;
    return (index & 0xc71c71c7u) ^ quotient ^ ((quotient >> 2u) & 0x06186186u) ^ (quotient >> 3u);
}

// Pairs of bits are numbers of the field of four elements, whose generator w is 2: times w, and times w^2.
INLINE uint TimesW(uint x) {
    uint high = (x >> 1u) & 0x55555555u;
    uint low = x & 0x55555555u;
    return high | ((low ^ high) << 1u);
}
INLINE uint TimesW2(uint x) {
    uint high = (x >> 1u) & 0x55555555u;
    uint low = x & 0x55555555u;
    return (low ^ high) | (low << 1u);
}

// Returns the index at which the second draw of a pair takes the dimensions that the first takes at `index`:
// Pascal's triangle over the field of four elements, with powers of w. Of blocks of 4^k points the first two
// numbers of both draws are then a (0,k,4)-net in base 4 (Faure's sequence), and those of each a (0,2k,2)-net
// in base 2 as before. A. Ahmed et al. 2024, "SZ Sequences: Binary-Based (0, 2^q)-Sequences".
INLINE uint SobolSecondOfPair(uint index) {
    index ^= TimesW2(index >> 16u);
    index ^= TimesW((index >> 8u) & 0x00ff00ffu);
    index ^= TimesW2((index >> 4u) & 0x0f0f0f0fu);
    index ^= TimesW((index >> 2u) & 0x33333333u);
    return index;
}

// Returns the seed of a draw, from which the seeds of its three scramblings are derived.
INLINE uint SobolDrawSeed(Sampler rng) {
    return MixBits(rng.pixelSeed ^ (rng.dimension * 0x9e3779b9u));
}

INLINE uint SobolSubSeed(uint drawSeed, uint factor) {
    uint x = drawSeed * factor;
    return x ^ (x >> 15u);
}

// Returns the sample index shuffled by nested scrambling: aligned blocks of 2^k indices go to aligned blocks.
INLINE uint SobolShuffledIndex(Sampler rng, uint drawSeed) {
    return bitfieldReverse(OwenScrambleReversed(rng.index, drawSeed));
}

INLINE float SobolDraw1D(Sampler rng) {
    uint seed = SobolDrawSeed(rng);
    uint index = SobolShuffledIndex(rng, seed);
    return BitsToUnit(bitfieldReverse(OwenScrambleReversed(index, SobolSubSeed(seed, 0x2c1b3c6du))));
}

INLINE vec2 SobolDraw2D(Sampler rng) {
    uint seed = SobolDrawSeed(rng);
    uint index = SobolShuffledIndex(rng, seed);
    uint first = OwenScrambleReversed(index, SobolSubSeed(seed, 0x2c1b3c6du));
    uint second = OwenScrambleReversed(SobolSecondReversed(index), SobolSubSeed(seed, 0x297a2d39u));
    return vec2(BitsToUnit(bitfieldReverse(first)), BitsToUnit(bitfieldReverse(second)));
}

INLINE vec3 SobolDraw3D(Sampler rng) {
    uint seed = SobolDrawSeed(rng);
    uint index = SobolShuffledIndex(rng, seed);
    uint first = OwenScrambleReversed(index, SobolSubSeed(seed, 0x2c1b3c6du));
    uint second = OwenScrambleReversed(SobolSecondReversed(index), SobolSubSeed(seed, 0x297a2d39u));
    uint third = OwenScrambleReversed(SobolThirdReversed(index), SobolSubSeed(seed, 0x1b56c4e9u));
    return vec3(BitsToUnit(bitfieldReverse(first)), BitsToUnit(bitfieldReverse(second)),
                BitsToUnit(bitfieldReverse(third)));
}

INLINE vec3 SobolDraw3DOfPair(Sampler rng, uint first) {
    uint seed = SobolDrawSeed(rng);
    bool isSecond = rng.dimension != first;
    rng.dimension = first;
    uint index = SobolShuffledIndex(rng, SobolDrawSeed(rng));
    if (isSecond) index = SobolSecondOfPair(index);
    uint x = OwenScrambleReversed(index, SobolSubSeed(seed, 0x2c1b3c6du));
    uint y = OwenScrambleReversed(SobolSecondReversed(index), SobolSubSeed(seed, 0x297a2d39u));
    uint z = OwenScrambleReversed(SobolThirdOfPairReversed(index), SobolSubSeed(seed, 0x1b56c4e9u));
    return vec3(BitsToUnit(bitfieldReverse(x)), BitsToUnit(bitfieldReverse(y)),
                BitsToUnit(bitfieldReverse(z)));
}

INLINE uvec4 Pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v = v ^ (v >> 16u);
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

INLINE vec3 PcgDraw(Sampler rng) {
    // The fourth word is free: the seed is in pixelSeed.
    uvec4 bits = Pcg4d(uvec4(rng.pixelSeed, rng.index, rng.dimension, 0u));
    return vec3(BitsToUnit(bits.x), BitsToUnit(bits.y), BitsToUnit(bits.z));
}

// Encrypts (pixel, sample) with the dimension in the key.
INLINE vec2 TeaDraw(Sampler rng) {
    uint v0 = rng.pixelSeed;
    uint v1 = rng.index;
    uint key0 = 0xa341316cu ^ rng.dimension;
    uint sum = 0u;
    for (uint i = 0u; i < 8u; ++i) {
        sum += 0x9e3779b9u;
        v0 += ((v1 << 4u) + key0) ^ (v1 + sum) ^ ((v1 >> 5u) + 0xc8013ea4u);
        v1 += ((v0 << 4u) + 0xad90777du) ^ (v0 + sum) ^ ((v0 >> 5u) + 0x7e95761eu);
    }
    return vec2(BitsToUnit(v0), BitsToUnit(v1));
}

INLINE Sampler StartPixelSample(uvec2 pixel, uint sampleIndex, uint seed) {
    Sampler rng;
    rng.pixelSeed = MixBits((pixel.x | (pixel.y << 16u)) ^ MixBits(seed + 0x9e3779b9u));
    rng.index = ActiveSamplerKind() == kSamplerKindSobol ? bitfieldReverse(sampleIndex) : sampleIndex;
    rng.dimension = 0u;
    return rng;
}

// Seed of decisions where ray `rayIndex` of a sample ends that use no dimension: walks between facets.
INLINE uint FacetSeed(Sampler rng, uint rayIndex) {
    return MixBits(rng.pixelSeed ^ MixBits(rng.index * 0x9e3779b9u + rayIndex));
}

// Returns the seed of AlphaTestSample for ray `rayIndex` of a sample. For Sobol it is the index of the
// sample, in an order that this ray of the pixel has for itself.
INLINE uint AlphaSeed(Sampler rng, uint rayIndex) {
    if (ActiveSamplerKind() != kSamplerKindSobol) return FacetSeed(rng, rayIndex);
    return OwenScrambleReversed(rng.index, MixBits(rng.pixelSeed ^ (rayIndex * 0x85ebca6bu)));
}

// Returns the number by which the surface of index `surface` stops a ray or lets it pass: the same in every
// call, in any order. For Sobol each surface has a sequence of its own, of which aligned blocks of 2^k
// samples are even.
INLINE float AlphaTestSample(uint alphaSeed, uint surface) {
    uint seed = MixBits(surface);
    uint index = bitfieldReverse(OwenScrambleReversed(alphaSeed, seed));
    return BitsToUnit(bitfieldReverse(OwenScrambleReversed(index, SobolSubSeed(seed, 0x2c1b3c6du))));
}

INLINE vec2 Get2D(INOUT(Sampler) rng) {
    vec2 u = vec2(0.0f, 0.0f);
    if (ActiveSamplerKind() == kSamplerKindPcg)
        u = vec2(PcgDraw(rng));
    else if (ActiveSamplerKind() == kSamplerKindTea)
        u = TeaDraw(rng);
    else
        u = SobolDraw2D(rng);
    rng.dimension += 2u;
    return u;
}

INLINE float Get1D(INOUT(Sampler) rng) {
    float u = 0.0f;
    if (ActiveSamplerKind() == kSamplerKindPcg)
        u = PcgDraw(rng).x;
    else if (ActiveSamplerKind() == kSamplerKindTea)
        u = TeaDraw(rng).x;
    else
        u = SobolDraw1D(rng);
    rng.dimension += 1u;
    return u;
}

// Draws numbers for a decision and for what follows from it: z decides, and x and y of those samples that
// decide alike are about as even as all are.
INLINE vec3 Get3D(INOUT(Sampler) rng) {
    if (ActiveSamplerKind() == kSamplerKindSobol || ActiveSamplerKind() == kSamplerKindPcg) {
        vec3 u = ActiveSamplerKind() == kSamplerKindPcg ? PcgDraw(rng) : SobolDraw3D(rng);
        rng.dimension += 3u;
        return u;
    }
    float z = Get1D(rng);
    return vec3(Get2D(rng), z);
}

// Draws three numbers for two decisions, one of which follows from the other: x and y of both together are
// stratified. `first` is the dimension of the first draw of the two.
INLINE vec3 Get3DOfPair(INOUT(Sampler) rng, uint first) {
    if (ActiveSamplerKind() != kSamplerKindSobol) return Get3D(rng);
    vec3 u = SobolDraw3DOfPair(rng, first);
    rng.dimension += 3u;
    return u;
}

SHADING_END

#endif
