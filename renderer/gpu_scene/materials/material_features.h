// The trace features that the materials of a scene need: all others are compiled out of pipelines. For
// renderer/gpu_scene alone. Threads: pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "shaders/shared/scene_records.h"
#include "shaders/shared/trace_options.h"

namespace raygraph {

struct SceneGeometry;  // renderer/gpu_scene/geometry/scene_geometry.h

// Tells whether microfacets with that roughness, which a texture (or gpu::kNoTexture) scales down, may
// reflect in a single direction somewhere (bxdf/microfacet.glsl, IsEffectivelySmooth).
bool MayBeSmooth(float roughness, uint32_t texture);

// Returns the features of kinds Textures, Lobes, Media and Hits (except MeshLights) that the meshes need
// somewhere, and those of all materials that their parts have in the variant that is shown. O(n log n).
TraceFeatures MaterialFeatures(std::span<const gpu::MaterialRecord> materials, uint32_t textureCount,
                               const SceneGeometry& geometry);

}  // namespace raygraph
