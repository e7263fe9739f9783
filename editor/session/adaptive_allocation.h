// How many samples the pixels of an adaptive render are to have. Threads: any.
#pragma once

#include <span>

#include "editor/session/adaptive_state.h"

namespace raygraph::session {

// Sets the wanted counts of one color's pixels by what was noted of the other color's: at least `least` of
// each, on average `average` or barely more, and beyond that in proportion to how much the samples around a
// pixel vary relative to their mean. Powers of two, where `least` and `average` are.
RAYGRAPH_API void AllocateSamples(rhi::Extent2D picture, uint32_t color, const NotedSamples& noted,
                                  std::span<const uint32_t> least, uint32_t average,
                                  std::span<uint32_t> wanted);

}  // namespace raygraph::session
