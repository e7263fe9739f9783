// Allocates the samples of an adaptive render to its pixels. Threads: any.
#pragma once

#include <span>

#include "editor/session/frames/adaptive_state.h"

namespace raygraph::session {

// Sets the wanted counts of one color's pixels from what was noted of the other color's. Each gets at least
// `least`; the average is `average` or barely more; the rest is proportional to the relative deviation of the
// samples around a pixel. Counts are powers of two if `least` and `average` are.
RAYGRAPH_API void AllocateSamples(rhi::Extent2D picture, uint32_t color, const PixelVariances& noted,
                                  std::span<const uint32_t> least, uint32_t average,
                                  std::span<uint32_t> wanted);

}  // namespace raygraph::session
