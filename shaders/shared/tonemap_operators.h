// The operators of core/tonemap.glsl, named once.
#ifndef RAYGRAPH_SHARED_TONEMAP_OPERATORS_H
#define RAYGRAPH_SHARED_TONEMAP_OPERATORS_H

#define RAYGRAPH_TONEMAP_OPERATORS(X) \
    X(Linear, 0)                      \
    X(Srgb, 1)                        \
    X(Reinhard, 2)                    \
    X(Aces, 3)                        \
    X(AgX, 4)                         \
    X(Neutral, 5)

#ifdef __cplusplus

#include <cstdint>

namespace raygraph {

#define RAYGRAPH_DECLARE_TONEMAP_OPERATOR(name, value) name = value,
enum class TonemapOperator : uint32_t { RAYGRAPH_TONEMAP_OPERATORS(RAYGRAPH_DECLARE_TONEMAP_OPERATOR) };
#undef RAYGRAPH_DECLARE_TONEMAP_OPERATOR

}  // namespace raygraph

#else

#define RAYGRAPH_DECLARE_TONEMAP_OPERATOR(name, value) const uint kTonemap##name = value;
RAYGRAPH_TONEMAP_OPERATORS(RAYGRAPH_DECLARE_TONEMAP_OPERATOR)
#undef RAYGRAPH_DECLARE_TONEMAP_OPERATOR

#endif

#endif
