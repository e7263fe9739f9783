// What the materials of a scene need of pipelines: what they do not need is compiled out. For
// renderer/gpu_scene alone. Threads: pure functions, for any thread.
#pragma once

#include <cstdint>

#include "shaders/shared/trace_options.h"

namespace raygraph {

struct SceneResources;  // renderer/gpu_scene/scene_resources.h

// Whether facets of that roughness, which a texture (or gpu::kNoTexture) scales down, may reflect in a single
// direction somewhere (bxdf/microfacet.glsl, IsEffectivelySmooth).
bool MayBeSmooth(float roughness, uint32_t texture);

// Returns the features of kinds Textures, Lobes, Media and Hits (but MeshLights) that the materials in use,
// and the meshes with them, need somewhere.
TraceFeatures MaterialFeatures(const SceneResources& resources);

}  // namespace raygraph
