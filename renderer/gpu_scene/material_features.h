// What the materials of a scene need of pipelines: what they do not need is compiled out. For
// renderer/gpu_scene alone. Threads: pure functions, for any thread.
#pragma once

#include <cstdint>

namespace raygraph {

struct SceneResources;  // renderer/gpu_scene/scene_resources.h

// Whether facets of that roughness, which a texture (or gpu::kNoTexture) scales down, may reflect in a single
// direction somewhere (bxdf/microfacet.glsl, IsEffectivelySmooth).
bool MayBeSmooth(float roughness, uint32_t texture);

// What lobes the materials in use may have at some point of them (shaders/bxdf/gltf_lobes.glsl): bits of
// kTraceFeatures. Unlit ones have none.
uint32_t LobeFeatures(const SceneResources& resources);
// Whether there are textures, whether some are transformed, and whether vertices have colors: bits of
// kTraceFeatures.
uint32_t TextureFeatures(const SceneResources& resources);
// Whether surfaces of some material in use bound a medium.
bool HasVolumes(const SceneResources& resources);

}  // namespace raygraph
