// Blurred copies of a picture in one texture, each half the size of the one before, stacked from the top:
// level 1 is half the picture's size.
#ifndef RAYGRAPH_SHARED_BLUR_LEVELS_H
#define RAYGRAPH_SHARED_BLUR_LEVELS_H

#ifdef __cplusplus
#include <cstdint>

namespace raygraph::gpu {
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#define RAYGRAPH_INLINE   inline
#else
#define RAYGRAPH_CONSTANT const
#define RAYGRAPH_INLINE
#endif

RAYGRAPH_CONSTANT uint kBlurLevels = 6u;

// Width or height of a level.
RAYGRAPH_INLINE uint BlurSize(uint size, uint level) {
    return (size + (1u << level) - 1u) >> level;
}

// First row of a level; of level kBlurLevels + 1, the height of all.
RAYGRAPH_INLINE uint BlurRow(uint height, uint level) {
    uint row = 0u;
    for (uint i = 1u; i < level; ++i) row += BlurSize(height, i);
    return row;
}

#undef RAYGRAPH_CONSTANT
#undef RAYGRAPH_INLINE

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif
