// The sums of a pixel, read from the textures of Accumulate, and what follows from them. Includers that read
// squares, too, define WITH_VARIANCE.
#ifndef RAYGRAPH_POST_PIXEL_SUMS_GLSL
#define RAYGRAPH_POST_PIXEL_SUMS_GLSL

#define PLANE_ACCESS readonly
#include "post/exact_planes.glsl"
#include "post/pixels.glsl"

struct PixelSums {
    uvec4 sums[4];
#ifdef WITH_VARIANCE
    uvec4 squares[4];
#endif
};

PixelSums SumsOf(ivec2 pixel) {
    PixelSums of;
    of.sums = uvec4[4](imageLoad(sum0, pixel), imageLoad(sum1, pixel), imageLoad(sum2, pixel),
                       imageLoad(sum3, pixel));
#ifdef WITH_VARIANCE
    of.squares = uvec4[4](imageLoad(squares0, pixel), imageLoad(squares1, pixel), imageLoad(squares2, pixel),
                          imageLoad(squares3, pixel));
#endif
    return of;
}

ExactSum SumOf(PixelSums pixel, int channel) {
    ExactSum sum;
    for (int k = 0; k < 4; ++k) sum.words[k] = pixel.sums[k][channel];
    return sum;
}

// Returns MeanOfExactSum for a count that needs no preparation.
uint MeanOfCount(ExactSum sum, uint count) {
    UintPair divisor;
    divisor.low = count;
    divisor.high = 0u;
    uint mean = NearestQuotient(MagnitudeOf(sum), kUnitExponent, divisor);
    return mean == 0u ? 0u : mean | (sum.words[3] & 0x80000000u);
}

#ifdef WITH_VARIANCE
// Returns the bits of the variance of a color channel.
uint VarianceOf(PixelSums pixel, int channel, uint count) {
    ExactSquares squares;
    for (int k = 0; k < 4; ++k) squares.words[k] = pixel.squares[k][channel];
    squares.words[4] = pixel.squares[channel].w;
    return VarianceOfExactSums(SumOf(pixel, channel), squares, count);
}
#endif

#endif
