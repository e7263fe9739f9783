// The declarations of every pass that traces the scene, matching shaders/scene/bindings.glsl. Threads: that
// of the Renderer.
#pragma once

#include <string>

#include "base/api.h"
#include "passes/trace.h"
#include "renderer/graph/pass_builder.h"

namespace raygraph::passes {

// The requested part of the picture. Error{Usage} if it is not within settings.extent.
RAYGRAPH_API Region RegionOf(const TraceSettings& settings);

// The parameter block of a camera-ray pass.
RAYGRAPH_API gpu::TraceParameters ParametersFor(const SceneIds& scene, const TraceSettings& settings);

// A pass binds only what its shaders use. How its rays treat surfaces that are not opaque:
enum class AlphaTest : uint8_t {
    Off,  // as opaque, no any-hit shader runs; for rays that meet only triangles (kMaskTriangles)
    On,   // alpha-tested; needs BindGeometry and BindMaterials, where there is alpha or a round primitive
};
// The miss and hit shaders of radiance rays, the TLAS with the BLASes that it references, and the parameters.
RAYGRAPH_API void BindTracing(PassBuilder& pass, const SceneIds& scene,
                              const gpu::TraceParameters& parameters, AlphaTest alphaTest);
// Those of shadow rays; beside BindTracing. Where the scene has alpha, thin walls or round primitives, needs
// BindGeometry and BindMaterials.
RAYGRAPH_API void BindShadowRays(PassBuilder& pass, const SceneIds& scene);
// Instance and geometry records: from a hit to its triangle.
RAYGRAPH_API void BindGeometry(PassBuilder& pass, const SceneIds& scene);
RAYGRAPH_API void BindMaterials(PassBuilder& pass, const SceneIds& scene);
RAYGRAPH_API void BindEnvironment(PassBuilder& pass, const SceneIds& scene);
// The tables of light sampling.
RAYGRAPH_API void BindLights(PassBuilder& pass, const SceneIds& scene);
// The lobes that materials have under that model: bits of kTraceFeatures. None but glTF's own has any.
RAYGRAPH_API uint32_t LobeFeatures(const SceneIds& scene, const TraceSettings& settings);
// The variant of a shader that shades surfaces without the code of thin films, of stretched highlights, of
// light that is reflected back or passes matched media, if the scene has none of them:
// "raster/shade_plain.comp" for "raster/shade.comp". A device inlines that code before it finds that the
// features are off, which on a CPU device doubles the time of compilation.
RAYGRAPH_API std::string PlainVariant(std::string shader, const SceneIds& scene,
                                      const TraceSettings& settings);
// Those of direct light: settings.scattering and settings.lights.sampler, and what the scene has; whether
// textures are read at other levels than 0, if there are any.
RAYGRAPH_API void SpecializeDirect(PassBuilder& pass, const SceneIds& scene, const TraceSettings& settings,
                                   bool hasTextureLevels);
// The choices that TraceSettings makes when a pipeline is created.
RAYGRAPH_API void SpecializeTrace(PassBuilder& pass, const SceneIds& scene, const TraceSettings& settings);

}  // namespace raygraph::passes
