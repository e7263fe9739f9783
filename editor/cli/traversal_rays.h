// Rays of a scene by which ways of tracing are compared: what the camera sees, and where light goes from
// there. Threads: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "editor/session/picture_settings.h"
#include "renderer/bvh/wide_scene.h"
#include "renderer/scene/camera_view.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::cli {

// The triangles that the scene shows, at rest.
BvhScene BvhSceneOf(const scene::SceneData& data);

// One through each pixel, in tiles of 8x4 pixels.
std::vector<gpu::BenchRay> CameraRays(const scene::CameraView& view, Extent2D size);
// Of what the rays hit: one each, cosine distributed around the normal on the ray's side.
std::vector<gpu::BenchRay> BounceRays(const BvhScene& scene, std::span<const gpu::BenchRay> rays,
                                      std::span<const gpu::WideHit> hits, uint32_t seed);
// Of what the rays hit: one each to some point of the middle of the upper face of the scene's bounds.
std::vector<gpu::BenchRay> ShadowRays(const BvhScene& scene, std::span<const gpu::BenchRay> rays,
                                      std::span<const gpu::WideHit> hits, uint32_t seed);

}  // namespace raygraph::cli
