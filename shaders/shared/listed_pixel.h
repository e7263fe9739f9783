// A pixel that Trace takes samples of, where pixels have different numbers of them (passes/pixel_list.h).
#ifndef RAYGRAPH_SHARED_LISTED_PIXEL_H
#define RAYGRAPH_SHARED_LISTED_PIXEL_H

#ifdef __cplusplus
#include <cstdint>

namespace raygraph::gpu {
using uint = uint32_t;
#endif

struct ListedPixel {
    uint texel;        // texel of the traced part of the picture: x + y * 65536
    uint sampleIndex;  // index of its first sample
};

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif
