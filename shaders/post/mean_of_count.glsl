// The mean of exact sums whose count is not the same for all pixels. Includers include exact_planes.glsl.
#ifndef RAYGRAPH_POST_MEAN_OF_COUNT_GLSL
#define RAYGRAPH_POST_MEAN_OF_COUNT_GLSL

// As MeanOfExactSum, of a count that needs no preparation.
uint MeanOfCount(ExactSum sum, uint count) {
    UintPair divisor;
    divisor.low = count;
    divisor.high = 0u;
    uint mean = NearestQuotient(MagnitudeOf(sum), kUnitExponent, divisor);
    return mean == 0u ? 0u : mean | (sum.words[3] & 0x80000000u);
}

#endif
