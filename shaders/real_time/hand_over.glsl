// The samples of a pixel that a tile may have reached, for HandOver (passes/real_time.h).
#ifndef RAYGRAPH_REAL_TIME_HAND_OVER_GLSL
#define RAYGRAPH_REAL_TIME_HAND_OVER_GLSL

#include "shared/real_time.h"

const int kBlock = int(kHandOverBlock);
const uint kFewSamples = 4u;

layout(push_constant) uniform Constants {
    uint sampleCount;  // of each pixel; one more of those that a tile of the next sample has reached
    uint doneRows, doneColumns, bandHeight;
} constants;

uint SamplesAt(ivec2 pixel) {
    uvec2 at = uvec2(pixel);
    bool isAhead = at.y < constants.doneRows ||
                   (at.y < constants.doneRows + constants.bandHeight && at.x < constants.doneColumns);
    return constants.sampleCount + (isAhead ? 1u : 0u);
}

#endif
