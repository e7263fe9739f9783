// The samplers of core/rng.glsl, named once: the host sets specialization constant kSamplerKindConstantId to
// one of these when a pipeline is created.
#ifndef RAYGRAPH_SHARED_SAMPLER_KINDS_H
#define RAYGRAPH_SHARED_SAMPLER_KINDS_H

#define RAYGRAPH_SAMPLER_KINDS(X) \
    X(Sobol, 0)                   \
    X(Pcg, 1)                     \
    X(Tea, 2)

#ifdef __cplusplus

#include <cstdint>

namespace raygraph {

#define RAYGRAPH_DECLARE_SAMPLER_KIND(name, value) name = value,
enum class SamplerKind : uint32_t { RAYGRAPH_SAMPLER_KINDS(RAYGRAPH_DECLARE_SAMPLER_KIND) };
#undef RAYGRAPH_DECLARE_SAMPLER_KIND

inline constexpr uint32_t kSamplerKindConstantId = 0;

}  // namespace raygraph

#else

#define RAYGRAPH_DECLARE_SAMPLER_KIND(name, value) const uint kSamplerKind##name = value;
RAYGRAPH_SAMPLER_KINDS(RAYGRAPH_DECLARE_SAMPLER_KIND)
#undef RAYGRAPH_DECLARE_SAMPLER_KIND

const int kSamplerKindConstantId = 0;

#endif

#endif
