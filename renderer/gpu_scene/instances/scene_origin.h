// The origin of the device's coordinates. Threads: pure functions, for any thread; an object for one at
// a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// Meters. The origin lies on a grid of this size, and stays until the reference point is farther than this
// along an axis: a camera that moves back and forth does not move it.
inline constexpr double kOriginGrid = 128.0;

// The reference point is the point of the scene's box nearest to the eye: everything visible is there or
// beyond. Scenes that are seen within 128 m of the world's origin keep (0, 0, 0). `scene` is in world space.
// Returns `current` for an empty scene and for an eye that is not finite.
glm::dvec3 ChooseSceneOrigin(const glm::dvec3& current, const glm::dvec3& eye, const scene::Bounds& scene);

// Meters: where float's steps are still 0.06 mm.
inline constexpr double kOriginReach = 1024.0;
inline constexpr uint32_t kFarViewpointsToMove = 8;

// When the origin follows the viewpoint. Alternating viewpoints, of several viewports, would move it back
// and forth in every frame: while one of the last kFarViewpointsToMove was near, it stays for others
// within kOriginReach.
class OriginHysteresis {
  public:
    // For one viewpoint: the current origin, and the one that ChooseSceneOrigin returns.
    bool Moves(const glm::dvec3& current, const glm::dvec3& wanted);

  private:
    uint32_t m_farCount = kFarViewpointsToMove;  // in a row; the first viewpoint alternates with no other
};

}  // namespace raygraph
