// What becomes of light that meets more than one facet of a rough surface, named once: the host sets
// specialization constant kMultiscatterConstantId to one of these when a pipeline is created.
//
// Off: it is lost. Lut: single scattering, scaled up by tables to what the walk returns. Walk: a random walk
// among the facets, the truth that the tables come from.
#ifndef RAYGRAPH_SHARED_MULTISCATTER_KINDS_H
#define RAYGRAPH_SHARED_MULTISCATTER_KINDS_H

#define RAYGRAPH_MULTISCATTER_KINDS(X) \
    X(Off, 0)                          \
    X(Lut, 1)                          \
    X(Walk, 2)

#ifdef __cplusplus

#include <cstdint>

namespace raygraph {

#define RAYGRAPH_DECLARE_MULTISCATTER_KIND(name, value) name = value,
enum class MultiscatterKind : uint32_t { RAYGRAPH_MULTISCATTER_KINDS(RAYGRAPH_DECLARE_MULTISCATTER_KIND) };
#undef RAYGRAPH_DECLARE_MULTISCATTER_KIND

inline constexpr uint32_t kMultiscatterConstantId = 4;

}  // namespace raygraph

#else

#define RAYGRAPH_DECLARE_MULTISCATTER_KIND(name, value) const uint kMultiscatterKind##name = value;
RAYGRAPH_MULTISCATTER_KINDS(RAYGRAPH_DECLARE_MULTISCATTER_KIND)
#undef RAYGRAPH_DECLARE_MULTISCATTER_KIND

const int kMultiscatterConstantId = 4;

#endif

#endif
