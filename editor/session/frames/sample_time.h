// Chooses the time of a shutter at which a sample sees the scene. Threads: pure functions, for any thread.
#pragma once

#include <cstdint>

#include "base/api.h"

namespace raygraph::session {

// Returns the position from 0, when the shutter opens, to below 1, when it closes. It is the same for all
// pixels of the sample. Each aligned block of 2^k samples has one time in each of 2^k equal parts, at random
// positions within them, so that any number of samples is unbiased, and their mean converges to the integral
// over the shutter.
//
// The sequence of van der Corput, Owen-scrambled: each bit of the time is flipped by a hash of those above it
// (Owen 1995, "Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences"). Dimensions of a pixel shuffle their
// sample indices each by itself (shaders/core/rng.glsl), so that none is coupled to this one.
RAYGRAPH_API double ShutterPosition(uint32_t sampleIndex, uint32_t seed);

}  // namespace raygraph::session
