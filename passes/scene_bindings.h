// What every pass that traces the scene declares: the twin of shaders/scene/bindings.glsl.
#pragma once

#include "passes/trace.h"
#include "renderer/graph/pass_builder.h"

namespace raygraph::passes {

// The parameter block of a camera-ray pass.
gpu::TraceParameters ParametersFor(const SceneIds& scene, const TraceSettings& settings);

// Declares the scene's resources, its parameters, and the miss and hit shaders of radiance rays.
void BindScene(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters);

}  // namespace raygraph::passes
