// What a path tracing pipeline can be specialized to, named once. The host sets the specialization constants
// of these names when a pipeline is created; branches on them fold.
#ifndef RAYGRAPH_SHARED_TRACE_OPTIONS_H
#define RAYGRAPH_SHARED_TRACE_OPTIONS_H

// How surfaces scatter (bxdf/bsdf.glsl).
//   Gltf:      the material as the file says
//   Lambert:   base colour as albedo, nothing else
//   Lafortune: modified Phong, base colour and roughness mapped onto it
#define RAYGRAPH_BRDF_MODELS(X) \
    X(Gltf, 0)                  \
    X(Lambert, 1)               \
    X(Lafortune, 2)

// How light found by sampling lights and light found by sampling the BSDF are weighed against each other.
//   Off: light sampling alone, where it can find the light at all
#define RAYGRAPH_MIS_HEURISTICS(X) \
    X(Balance, 0)                  \
    X(Power, 1)                    \
    X(Off, 2)

// How a path ends before its light is spent.
//   Throughput: survival falls with what the path carries
//   Constant:   every bounce survives with one probability
//   Frame:      one depth for all pixels of a sample, drawn by the host; distributed as Constant's
//   Off:        by absorption, escape or the depth limit alone
#define RAYGRAPH_ROULETTES(X) \
    X(Throughput, 0)          \
    X(Constant, 1)            \
    X(Frame, 2)               \
    X(Off, 3)

// What a scene needs of the integrator: bits of kTraceFeatures. A bit that is off takes its code away, which
// is time on a device and, on one that is a CPU, seconds of compilation.
//   LightSampling:    lights are sampled, of which there are
//   TriangleLights, PunctualLights, EnvironmentLight
//   Textures, Glass:  materials have textures, let light through
//   Volumes:          surfaces enclose media
//   ProbeMedia:       the camera may be inside of some
//   ThinWalls:        light goes straight on through some surfaces
//   AnyHit:           some surfaces are there or not to a ray as an any-hit shader says
// and of the biases, one that changes what a surface is:
//   ShadowTerminator: opaque surfaces are where their vertex normals bend them to (scene/surface.glsl)
#define RAYGRAPH_TRACE_FEATURES(X) \
    X(LightSampling, 1)            \
    X(TriangleLights, 2)           \
    X(PunctualLights, 4)           \
    X(EnvironmentLight, 8)         \
    X(Textures, 16)                \
    X(Glass, 32)                   \
    X(Volumes, 64)                 \
    X(ProbeMedia, 128)             \
    X(ThinWalls, 256)              \
    X(AnyHit, 512)                 \
    X(ShadowTerminator, 1024)

#ifdef __cplusplus

#include <cstdint>

namespace raygraph {

#define RAYGRAPH_DECLARE(name, value) name = value,
enum class BrdfModel : uint32_t { RAYGRAPH_BRDF_MODELS(RAYGRAPH_DECLARE) };
enum class MisHeuristic : uint32_t { RAYGRAPH_MIS_HEURISTICS(RAYGRAPH_DECLARE) };
enum class Roulette : uint32_t { RAYGRAPH_ROULETTES(RAYGRAPH_DECLARE) };
#undef RAYGRAPH_DECLARE

#define RAYGRAPH_DECLARE(name, value) inline constexpr uint32_t kTrace##name = value;
RAYGRAPH_TRACE_FEATURES(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE

namespace shading {
#define RAYGRAPH_DECLARE(name, value) inline constexpr uint32_t kBrdf##name = value;
RAYGRAPH_BRDF_MODELS(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE
#define RAYGRAPH_DECLARE(name, value) inline constexpr uint32_t kMis##name = value;
RAYGRAPH_MIS_HEURISTICS(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE
#define RAYGRAPH_DECLARE(name, value) inline constexpr uint32_t kRoulette##name = value;
RAYGRAPH_ROULETTES(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE

// The options of this thread; on the device, specialization constants.
struct TraceOptions {
    BrdfModel brdf = BrdfModel::Gltf;
    MisHeuristic mis = MisHeuristic::Power;
    Roulette roulette = Roulette::Throughput;
    uint32_t features = ~(kTraceProbeMedia | kTraceShadowTerminator);
};
inline thread_local TraceOptions threadTraceOptions;
inline uint32_t ActiveBrdf() {
    return static_cast<uint32_t>(threadTraceOptions.brdf);
}
inline uint32_t ActiveMis() {
    return static_cast<uint32_t>(threadTraceOptions.mis);
}
inline uint32_t ActiveRoulette() {
    return static_cast<uint32_t>(threadTraceOptions.roulette);
}
inline bool HasTraceFeature(uint32_t bit) {
    return (threadTraceOptions.features & bit) != 0u;
}
}  // namespace shading

}  // namespace raygraph

#else

#define RAYGRAPH_DECLARE(name, value) const uint kBrdf##name = value;
RAYGRAPH_BRDF_MODELS(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE
#define RAYGRAPH_DECLARE(name, value) const uint kMis##name = value;
RAYGRAPH_MIS_HEURISTICS(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE
#define RAYGRAPH_DECLARE(name, value) const uint kRoulette##name = value;
RAYGRAPH_ROULETTES(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE
#define RAYGRAPH_DECLARE(name, value) const uint kTrace##name = value;
RAYGRAPH_TRACE_FEATURES(RAYGRAPH_DECLARE)
#undef RAYGRAPH_DECLARE

layout(constant_id = 5) const uint kBrdf = kBrdfGltf;
layout(constant_id = 7) const uint kMis = kMisPower;
layout(constant_id = 8) const uint kRoulette = kRouletteThroughput;
layout(constant_id = 9) const uint kTraceFeatures = 1023u;  // all that a scene may need
uint ActiveBrdf() {
    return kBrdf;
}
uint ActiveMis() {
    return kMis;
}
uint ActiveRoulette() {
    return kRoulette;
}
bool HasTraceFeature(uint bit) {
    return (kTraceFeatures & bit) != 0u;
}

#endif

#endif
