// The flags of lobes, BSDFs and samples of them (bxdf/bxdf.glsl): one source for C++ and GLSL. A lobe has at
// least one of the first two, and at least one of the last three. Threads: constants.
#ifndef RAYGRAPH_SHARED_BXDF_FLAGS_H
#define RAYGRAPH_SHARED_BXDF_FLAGS_H

#ifdef __cplusplus
#include <cstdint>

namespace raygraph {
#define RAYGRAPH_BXDF_FLAG(name, value) inline constexpr uint32_t kBxDF##name = value;
#else
#define RAYGRAPH_BXDF_FLAG(name, value) const uint kBxDF##name = value;
#endif

RAYGRAPH_BXDF_FLAG(None, 0u)
RAYGRAPH_BXDF_FLAG(Reflection, 1u)
RAYGRAPH_BXDF_FLAG(Transmission, 2u)
RAYGRAPH_BXDF_FLAG(Diffuse, 4u)
RAYGRAPH_BXDF_FLAG(Glossy, 8u)
RAYGRAPH_BXDF_FLAG(Specular, 16u)

#undef RAYGRAPH_BXDF_FLAG
#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif
