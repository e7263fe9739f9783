// The ways of choosing a light (lights/lights.glsl), named once: the host sets specialization constant
// kLightSamplerConstantId to one of these when a pipeline is created.
//
// Uniform: every light that shines alike.
// Power:   by power.
// Bvh:     by what each may contribute to the point at hand, through a tree over position and orientation.
#ifndef RAYGRAPH_SHARED_LIGHT_SAMPLERS_H
#define RAYGRAPH_SHARED_LIGHT_SAMPLERS_H

#define RAYGRAPH_LIGHT_SAMPLERS(X) \
    X(Uniform, 0)                  \
    X(Power, 1)                    \
    X(Bvh, 2)

#ifdef __cplusplus

#include <cstdint>

namespace raygraph {

#define RAYGRAPH_DECLARE_LIGHT_SAMPLER(name, value) name = value,
enum class LightSampler : uint32_t { RAYGRAPH_LIGHT_SAMPLERS(RAYGRAPH_DECLARE_LIGHT_SAMPLER) };
#undef RAYGRAPH_DECLARE_LIGHT_SAMPLER

inline constexpr uint32_t kLightSamplerConstantId = 6;

}  // namespace raygraph

#else

#define RAYGRAPH_DECLARE_LIGHT_SAMPLER(name, value) const uint kLightSampler##name = value;
RAYGRAPH_LIGHT_SAMPLERS(RAYGRAPH_DECLARE_LIGHT_SAMPLER)
#undef RAYGRAPH_DECLARE_LIGHT_SAMPLER

const int kLightSamplerConstantId = 6;

#endif

#endif
