// Where the device's coordinates begin. Threads: pure functions, for any thread; an object for one at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "renderer/scene/scene_data.h"

namespace raygraph {

// Meters. The origin lies on a grid of this size, and stays until the place that matters is farther than this
// along an axis: a camera that moves to and fro does not move it.
inline constexpr double kOriginGrid = 128.0;

// The place that matters is that of the scene's box which is nearest to the eye: what is seen is there or
// beyond. Scenes that are seen within 128 m of the world's origin keep (0, 0, 0). `scene` is in the world; an
// empty one is nowhere, and `current` is returned; so it is for an eye that is not finite.
glm::dvec3 ChooseSceneOrigin(const glm::dvec3& current, const glm::dvec3& eye, const scene::Bounds& scene);

// Meters: where float's steps are still 0.06 mm.
inline constexpr double kOriginReach = 1024.0;
inline constexpr uint32_t kFarViewpointsToMove = 8;

// When the origin follows. Viewpoints that take turns, of several viewports, would move it to and fro in
// every frame: as long as one of the last kFarViewpointsToMove was near, others do with what is within
// kOriginReach.
class OriginTurns {
  public:
    // Of one viewpoint: the origin as it is, and as ChooseSceneOrigin wants it.
    bool Moves(const glm::dvec3& current, const glm::dvec3& wanted);

  private:
    uint32_t m_farCount = kFarViewpointsToMove;  // in a row; the first viewpoint has none to take turns with
};

}  // namespace raygraph
