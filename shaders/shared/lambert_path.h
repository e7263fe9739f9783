// Length of the paths that a loop and recursion are measured by (bench/lambert_path.glsl).
#ifndef RAYGRAPH_SHARED_LAMBERT_PATH_H
#define RAYGRAPH_SHARED_LAMBERT_PATH_H

#ifdef __cplusplus

#include <cstdint>

namespace raygraph {
inline constexpr uint32_t kLambertBounces = 10;
// The camera's ray and one a bounce, each traced by the closest hit of the one before.
inline constexpr uint32_t kLambertRecursion = kLambertBounces + 1;
}  // namespace raygraph

#else

const uint kLambertBounces = 10u;

#endif

#endif
