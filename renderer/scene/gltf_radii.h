// The radii of points and lines of a file. Internal to renderer/scene.
#pragma once

#include "renderer/scene/gltf_context.h"
#include "renderer/scene/round_primitives.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::scene {

// Returns the value that a decoded primitive has as its radii until SetRadii replaces it.
float AskedRadius(const RoundRadius& asked);

// After everything is placed: makes the radii those asked for, in the world, and extends all bounds by
// them. A mesh of several placements has its radius at the largest; of one whose scale differs by axis, it
// is that of the sphere that has the ellipsoid's volume.
void SetRadii(GltfContext& context, SceneData& scene);

}  // namespace raygraph::scene
