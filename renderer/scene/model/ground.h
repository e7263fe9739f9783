// A ground for pictures of a scene that has none: what it stands on, and where its shadow falls. Threads:
// pure functions.
#pragma once

#include "base/api.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

inline constexpr float kGroundReflectance = 0.5f;
// Half a side of the ground, in radii of the bounds: a light that is 2 degrees above the horizon has its
// whole shadow on it.
inline constexpr float kGroundRadii = 30.0f;
// Its distance to the bounds, in radii: a floor that the scene has there hides it.
inline constexpr float kGroundGap = 1e-4f;

// Returns a horizontal square just below the bounds, of a gray diffuse surface that is a shadow catcher
// (Material::isShadowCatcher) and is seen from above alone. Empty bounds give no ground.
RAYGRAPH_API SceneData GroundUnder(const Bounds& bounds);

}  // namespace raygraph::scene
