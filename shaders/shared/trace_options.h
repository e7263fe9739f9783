// What a path tracing pipeline can be specialized to, named once (core/trace_options.glsl).
#ifndef RAYGRAPH_SHARED_TRACE_OPTIONS_H
#define RAYGRAPH_SHARED_TRACE_OPTIONS_H

#include "choice.h"

// How surfaces scatter (bxdf/bsdf.glsl).
//   Gltf:      the material as the file says
//   Lambert:   base color as albedo, nothing else
//   Lafortune: modified Phong, base color and roughness mapped onto it
#define RAYGRAPH_BRDF_MODELS(X, Of)                                    \
    X(Of, Gltf, 0, "gltf", "")                                         \
    X(Of, Lambert, 1, "lambert", "base color as albedo, nothing else") \
    X(Of, Lafortune, 2, "lafortune", "modified Phong")

// The MIS weights of light sampling and BSDF sampling.
//   Off: light sampling alone, where it can find the light at all
#define RAYGRAPH_MIS_HEURISTICS(X, Of) \
    X(Of, Balance, 0, "balance", "")   \
    X(Of, Power, 1, "power", "")       \
    X(Of, Off, 2, "off", "")

// Russian roulette: how paths are terminated.
//   Throughput: survival falls with what the path carries
//   Constant:   every bounce survives with one probability
//   Frame:      one depth for all pixels of a sample, drawn by the host; distributed as Constant's
//   Off:        by absorption, escape or the depth limit alone
#define RAYGRAPH_ROULETTES(X, Of)                                 \
    X(Of, Throughput, 0, "throughput", "")                        \
    X(Of, Constant, 1, "constant", "each bounce survives with P") \
    X(Of, Frame, 2, "frame", "one depth a sample, drawn so")      \
    X(Of, Off, 3, "off", "")

// How the integrator's loop runs on a device: bits of kLoopOptions.
//   OneTrace: one place of the code traces all rays, shadow rays by the shaders of the others, which do the
//             same where neither ThinWalls nor MatchedMedia is set. For devices that compile each place anew
#define RAYGRAPH_LOOP_OPTIONS(X) X(OneTrace, 1)

// The features of the integrator that a scene needs: bits of kTraceFeatures. A bit that is off removes its
// code, which saves time on a device and, on a CPU device, seconds of compilation.
//   LightSampling:    lights are sampled, of which there are
//   TriangleLights, PunctualLights, EnvironmentLight
//   LightProfiles:    some punctual lights have one
//   MeshLights:       some triangle lights are those of a mesh that is placed often
//   Textures:         materials have textures
//   TextureTransforms: some are read elsewhere than at the primitive's texture coordinates, or along other
//                     axes than its tangents
//   VertexColors:     some vertices have a color
//   Glass, Metals, Opaque, Clearcoat, Sheen: materials have these lobes (bxdf/gltf_lobes.glsl): they transmit
//                     light, are metal, are a layer over a diffuse base, have a clear coat, have sheen
//   Smooth:           some materials or coats reflect in a single direction
//   Anisotropy:       highlights of some materials are stretched
//   Iridescence:      some are under a thin film
//   Dispersion:       some glass refracts colors differently
//   DiffuseTransmission: some opaque ones scatter light to their other side
//   Scattering:       some media scatter
//   Retroreflection:  facets of some materials reflect light back to where it came from
//   Volumes:          surfaces enclose media
//   MatchedMedia:     light goes straight on into and out of some, of the index of what is around them
//   ProbeMedia:       the camera may be inside of some
//   ThinWalls:        light goes straight on through some surfaces
//   Capsules:         some primitives are round
//   AnyHit:           some surfaces are there or not to a ray as an any-hit shader says
// and of the biases, those that change what a surface is:
//   ShadowTerminator: opaque surfaces are where their vertex normals bend them to (scene/surface.glsl)
//   TextureLod:       textures are read at a level that fits the path's cone (core/ray_cone.glsl), or, by
//                     passes over pixels, the pixel's footprint (raster/pixel_footprint.glsl)
// and of the camera:
//   HiddenEnvironment: it does not see the environment
// and of the samples:
//   PixelList: they are of the pixels of a list (passes/pixel_list.h), not of all
#define RAYGRAPH_TRACE_FEATURES(X)  \
    X(LightSampling, 1)             \
    X(TriangleLights, 2)            \
    X(PunctualLights, 4)            \
    X(EnvironmentLight, 8)          \
    X(Textures, 16)                 \
    X(Glass, 32)                    \
    X(Volumes, 64)                  \
    X(ProbeMedia, 128)              \
    X(ThinWalls, 256)               \
    X(AnyHit, 512)                  \
    X(ShadowTerminator, 1024)       \
    X(Metals, 2048)                 \
    X(Opaque, 4096)                 \
    X(TextureTransforms, 8192)      \
    X(Clearcoat, 16384)             \
    X(Sheen, 32768)                 \
    X(Anisotropy, 65536)            \
    X(Iridescence, 131072)          \
    X(Dispersion, 262144)           \
    X(DiffuseTransmission, 524288)  \
    X(Scattering, 1048576)          \
    X(LightProfiles, 2097152)       \
    X(TextureLod, 4194304)          \
    X(MatchedMedia, 8388608)        \
    X(Retroreflection, 16777216)    \
    X(Capsules, 33554432)           \
    X(Smooth, 67108864)             \
    X(MeshLights, 134217728)        \
    X(VertexColors, 536870912)      \
    X(HiddenEnvironment, 268435456) \
    X(PixelList, 1073741824)

#ifdef __cplusplus
namespace raygraph {
RAYGRAPH_CHOICE(BrdfModel, RAYGRAPH_BRDF_MODELS)
RAYGRAPH_CHOICE(MisHeuristic, RAYGRAPH_MIS_HEURISTICS)
RAYGRAPH_CHOICE(Roulette, RAYGRAPH_ROULETTES)
#define RAYGRAPH_DECLARE(name, value)      inline constexpr uint32_t kTrace##name = value;
#define RAYGRAPH_DECLARE_LOOP(name, value) inline constexpr uint32_t kLoop##name = value;
#else
#define RAYGRAPH_DECLARE(name, value)      const uint kTrace##name = value;
#define RAYGRAPH_DECLARE_LOOP(name, value) const uint kLoop##name = value;
#endif

RAYGRAPH_CHOICE_CONSTANTS(Brdf, RAYGRAPH_BRDF_MODELS)
RAYGRAPH_CHOICE_CONSTANTS(Mis, RAYGRAPH_MIS_HEURISTICS)
RAYGRAPH_CHOICE_CONSTANTS(Roulette, RAYGRAPH_ROULETTES)
RAYGRAPH_TRACE_FEATURES(RAYGRAPH_DECLARE)
RAYGRAPH_LOOP_OPTIONS(RAYGRAPH_DECLARE_LOOP)
// The lobes through which light passes to the other side of a surface.
RAYGRAPH_DECLARE(Transmission, kTraceGlass | kTraceDiffuseTransmission)
#undef RAYGRAPH_DECLARE
#undef RAYGRAPH_DECLARE_LOOP

#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif
