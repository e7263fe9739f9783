// The declarations of every pass that traces the scene, matching shaders/scene/bindings.glsl. Threads: that
// of the Renderer.
#pragma once

#include "base/api.h"
#include "passes/trace.h"
#include "renderer/graph/pass_builder.h"

namespace raygraph::passes {

// Returns the requested part of the picture. Error{Usage} if it is not within settings.extent.
RAYGRAPH_API Region RegionOf(const TraceSettings& settings);
// Returns the extent of the texels that a sample takes in the outputs of Trace.
RAYGRAPH_API Extent2D TracedExtent(const TraceSettings& settings);
// Throws Error{Usage} naming the pass if the settings are for a part of the picture.
RAYGRAPH_API void RequireFullFrame(const TraceSettings& settings, const char* pass);

// Returns the parameter block of a camera-ray pass.
RAYGRAPH_API gpu::TraceParameters ParametersFor(const SceneIds& scene, const TraceSettings& settings);

// A pass binds only what its shaders use. How its rays treat surfaces that are not opaque:
enum class AlphaTest : uint8_t {
    Off,  // as opaque, no any-hit shader runs; for rays that meet only triangles (kMaskTriangles)
    On,   // alpha-tested; needs BindGeometry and BindMaterials, where there is alpha or a round primitive
};
// Binds the miss and hit shaders of radiance rays, the TLAS with the BLASes that it references, and the
// parameters.
RAYGRAPH_API void BindTracing(PassBuilder& pass, const SceneIds& scene,
                              const gpu::TraceParameters& parameters, AlphaTest alphaTest);
// Binds the hit shaders of a ray type for the instances of a number (GpuScene::SetHitSet), and for those of
// all other numbers that are not bound if it is 0. Round primitives get an intersection shader, which needs
// BindGeometry and BindMaterials where the scene has any (kTraceCapsules).
RAYGRAPH_API void BindHits(PassBuilder& pass, const SceneIds& scene, RayType rayType,
                           const HitGroupShaders& shaders, uint32_t number = 0);
// Binds what shadow rays need, in addition to BindTracing. Where the scene has alpha, thin walls or round
// primitives, BindGeometry and BindMaterials are needed too.
RAYGRAPH_API void BindShadowRays(PassBuilder& pass, const SceneIds& scene);
// Returns whether Trace's rays traverse the scene's own trees.
RAYGRAPH_API bool UsesSoftwareTraversal(const SceneIds& scene, const TraceSettings& settings);
// Binds trees and parameters in place of both, for a compute pass that defines SOFTWARE_TRAVERSAL
// (shaders/scene/trace_rays.glsl). Needs BindGeometry and BindMaterials.
RAYGRAPH_API void BindSoftwareTracing(PassBuilder& pass, const SceneIds& scene,
                                      const gpu::TraceParameters& parameters);
// Binds what the integrator's loop needs to trace shadow rays, in addition to BindTracing and
// SpecializeTrace. On a CPU device, where no walls and media let light through, this adds no shader.
RAYGRAPH_API void BindLoopRays(PassBuilder& pass, const rhi::Device& device, const SceneIds& scene,
                               const TraceSettings& settings);
// Binds instance records, and the vertices of deformed meshes, which they address.
RAYGRAPH_API void BindInstances(PassBuilder& pass, const SceneIds& scene);
// Binds instance and geometry records, by which a shader finds the triangle of a hit.
RAYGRAPH_API void BindGeometry(PassBuilder& pass, const SceneIds& scene);
RAYGRAPH_API void BindMaterials(PassBuilder& pass, const SceneIds& scene);
RAYGRAPH_API void BindEnvironment(PassBuilder& pass, const SceneIds& scene);
// Binds the tables of light sampling.
RAYGRAPH_API void BindLights(PassBuilder& pass, const SceneIds& scene);
// Sets the constants of HasTraceFeature in the pass's shaders; SpecializeDirect and SpecializeTrace do it,
// too.
RAYGRAPH_API void SpecializeFeatures(PassBuilder& pass, TraceFeatures features);
// Sets the constants of direct light: settings.scattering and settings.lights.sampler, and what the scene
// has; and whether textures are read at levels other than 0, if there are any.
RAYGRAPH_API void SpecializeDirect(PassBuilder& pass, const SceneIds& scene, const TraceSettings& settings,
                                   bool hasTextureLevels);
// Returns the features of the scene that the settings use, and those that the settings add.
RAYGRAPH_API TraceFeatures ProgramFeatures(const SceneIds& scene, const TraceSettings& settings);
// Returns the scene as one that needs these features, too, but those that follow from settings: Trace's
// program has them, and the samples have the same mean. One program then does for scenes that need them or
// not.
RAYGRAPH_API SceneIds WithFeatures(const SceneIds& scene, TraceFeatures features);
// Sets the choices that TraceSettings makes when a pipeline is created.
RAYGRAPH_API void SpecializeTrace(PassBuilder& pass, const SceneIds& scene, const TraceSettings& settings);

}  // namespace raygraph::passes
