// What every pass that traces the scene declares: the twin of shaders/scene/bindings.glsl.
#pragma once

#include "passes/trace.h"
#include "renderer/graph/pass_builder.h"

namespace raygraph::passes {

// The parameter block of a camera-ray pass.
gpu::TraceParameters ParametersFor(const SceneIds& scene, const TraceSettings& settings);

// A pass binds what its shaders use, and no more.
// The miss and hit shaders of radiance rays, the TLAS with what it points at, and the parameters.
void BindTracing(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters);
// Instance and geometry records: from a hit to its triangle.
void BindGeometry(PassBuilder& pass, const SceneIds& scene);
void BindMaterials(PassBuilder& pass, const SceneIds& scene);
void BindEnvironment(PassBuilder& pass, const SceneIds& scene);

}  // namespace raygraph::passes
