// The samples of a pixel that a tile may have reached, for HandOver (passes/real_time.h).
#ifndef RAYGRAPH_REAL_TIME_HAND_OVER_GLSL
#define RAYGRAPH_REAL_TIME_HAND_OVER_GLSL

#include "post/pixels.glsl"
#include "shared/real_time.h"

const int kBlock = int(kHandOverBlock);
const uint kFewSamples = 8u;  // fewer say little about their variance

layout(push_constant) uniform Constants {
    uint sampleCount;  // of each pixel; one more of those that a tile of the next sample has reached
    uint doneRows, doneColumns, bandHeight;
} constants;

uint SamplesAt(ivec2 pixel) {
    return SamplesAt(uvec2(pixel), constants.sampleCount, constants.doneRows, constants.doneColumns,
                     constants.bandHeight);
}

#endif
