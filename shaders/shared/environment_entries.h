// The table by which directions to the environment are chosen, as the shaders read it: one source for C++ and
// GLSL, scalar layout. The buffer holds an entry for each row of the map's cells, then those of each row's
// cells.
#ifndef RAYGRAPH_SHARED_ENVIRONMENT_ENTRIES_H
#define RAYGRAPH_SHARED_ENVIRONMENT_ENTRIES_H

#ifdef __cplusplus

#include <cstdint>

namespace raygraph::gpu {
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

// Ends are multiples of 1 / this, as random numbers are.
RAYGRAPH_CONSTANT uint kEnvironmentSteps = 0x1000000u;

// u chooses the first entry whose `end` is above it. So neighbors of u choose neighbors, and samples that are
// spread evenly stay so; those of an alias table do not.
struct EnvironmentEntry {
    float end;
    // For entry i of n: no u in the i-th nth, nor one that rounds to it, chooses an entry before `guide`.
    uint guide;
    float probability;  // of this row; of this cell in the whole map
};

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
static_assert(sizeof(EnvironmentEntry) == 3 * 4);
}  // namespace raygraph::gpu
#endif

#endif
