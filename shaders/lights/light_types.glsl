// Common types of this folder: records, the context of light sampling, and the active sampler.
#ifndef RAYGRAPH_LIGHTS_LIGHT_TYPES_GLSL
#define RAYGRAPH_LIGHTS_LIGHT_TYPES_GLSL

#include "core/math.glsl"
#include "core/option.h"
#include "core/trace_options.glsl"
#include "shared/light_records.h"
#include "shared/choice.h"

#ifdef __cplusplus
namespace raygraph::shading {
using glm::unpackSnorm2x16;
using gpu::AliasEntry;
using gpu::EnvironmentEntry;
using gpu::kEnvironmentSteps;
using gpu::kLightDirectional;
using gpu::kLightDoubleSided;
using gpu::kLightMesh;
using gpu::kLightMirrored;
using gpu::kLightOutward;
using gpu::kLightNodeIndex;
using gpu::kLightNodeLeaf;
using gpu::kLightNodeTwoSided;
using gpu::kLightPoint;
using gpu::kLightProfile;
using gpu::kLightSpot;
using gpu::kLightTriangle;
using gpu::kNoLight;
using gpu::kProfileTypeA;
using gpu::kProfileTypeB;
using gpu::kProfileTypeC;
using gpu::LightMeshRecord;
using gpu::LightNode;
using gpu::LightRecord;
using gpu::LightSetRecord;
}  // namespace raygraph::shading
#endif

SHADING_BEGIN

OPTION(LightSampler, LightSampler, 6, Bvh)

CONST float kInfinity = 3.0e38f;  // a distance beyond everything
CONST float kOneMinusEpsilon = 0.999999940395355f;

// Holds the point for which light is sampled. Both strategies of one estimate (light sampling and BSDF
// sampling) use the same context.
struct LightContext {
    vec3 position;  // distances and directions are taken from here
    vec3 normal;    // unit length: light from below its plane does not count. 0: light from both sides does
};

// Light that may arrive at a context.
struct LightSample {
    vec3 wi;         // unit length, to the light
    float distance;  // kInfinity: directional, environment
    vec3 target;     // where the light leaves from, off its surface; if distance is not kInfinity
    vec3 radiance;   // delta lights: irradiance at normal incidence, I / d^2 or E
    float pdf;       // per solid angle, times that of the light; delta lights: only the latter. 0: no sample
    uint isDelta;    // 1: no other strategy can find this light
    uint light;      // number of the light
    uint triangle;   // for a mesh: the triangle within it
};

INLINE LightSample NoLightSample() {
    LightSample result;
    result.wi = vec3(0.0f, 0.0f, 1.0f);
    result.distance = kInfinity;
    result.target = vec3(0.0f);
    result.radiance = vec3(0.0f);
    result.pdf = 0.0f;
    result.isDelta = 0u;
    result.light = kNoLight;
    result.triangle = 0u;
    return result;
}

// Returns true with probability `p`. The remainder of u is uniform again, so that it can be reused; each
// decision costs log2(1 / probability of the outcome) of its 24 bits.
INLINE bool SampleBernoulli(INOUT(float) u, float p) {
    bool isSuccess = u < p;
    u = min(isSuccess ? u / p : (u - p) / (1.0f - p), kOneMinusEpsilon);
    return isSuccess;
}

// Uniformly one of `count`; the remainder of u is uniform.
INLINE uint ChooseUniformly(INOUT(float) u, uint count) {
    float scaled = u * float(count);
    uint index = min(uint(scaled), count - 1u);
    u = clamp(scaled - float(index), 0.0f, kOneMinusEpsilon);
    return index;
}

SHADING_END

#endif
