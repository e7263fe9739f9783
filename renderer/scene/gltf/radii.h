// The radii of points and lines of a file. Internal to renderer/scene.
#pragma once

#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Returns the value that a decoded primitive has as its radii until SetRadii replaces it.
float RequestedRadius(const RoundRadius& asked);

// Sets the radii so that they are those asked for in world space, and extends all bounds by them. Call it
// when everything is placed. If a mesh has several placements, the largest gets the radius asked for; if its
// scale differs by axis, the radius is that of the sphere with the ellipsoid's volume.
void SetRadii(GltfContext& context, SceneData& scene);

}  // namespace raygraph::scene
