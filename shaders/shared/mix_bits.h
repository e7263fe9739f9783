// A hash of 32 bits: one source for C++ and GLSL.
#ifndef RAYGRAPH_SHARED_MIX_BITS_H
#define RAYGRAPH_SHARED_MIX_BITS_H

#ifdef __cplusplus
#include <cstdint>

namespace raygraph::gpu {
using uint = uint32_t;
#define RAYGRAPH_FUNCTION inline
#else
#define RAYGRAPH_FUNCTION
#endif

// Mixes the bits by a bijection: two multiply-xorshift rounds with constants found by search (C. Wellons,
// "Prospecting for Hash Functions", and its sequels).
RAYGRAPH_FUNCTION uint MixBits(uint x) {
    x ^= x >> 16u;
    x *= 0x21f0aaadu;
    x ^= x >> 15u;
    x *= 0x735a2d97u;
    x ^= x >> 15u;
    return x;
}

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif
#undef RAYGRAPH_FUNCTION

#endif
