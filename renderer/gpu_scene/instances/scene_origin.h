// The origin of the device's coordinates. Threads: pure functions; an object is used by one thread at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// In meters. The origin lies on a grid of this size, and stays until the reference point is farther than this
// along an axis: a camera that moves back and forth does not move it.
inline constexpr double kOriginGrid = 128.0;

// Returns the origin for an eye at this position. The reference point is the point of the scene's box nearest
// to the eye: everything visible is there or beyond. Scenes that are seen within 128 m of the world's origin
// keep (0, 0, 0). `scene` is in world space. Returns `current` for an empty scene and for an eye that is not
// finite.
glm::dvec3 ChooseSceneOrigin(const glm::dvec3& current, const glm::dvec3& eye, const scene::Bounds& scene);

// In meters: up to this distance, the steps of floats are at most 0.06 mm.
inline constexpr double kOriginReach = 1024.0;
inline constexpr uint32_t kFarViewpointsToMove = 8;

// Decides when the origin follows the viewpoint. Alternating viewpoints of several viewports would move it
// back and forth in every frame: while one of the last kFarViewpointsToMove viewpoints was near, the origin
// stays for others within kOriginReach.
class OriginHysteresis {
  public:
    // Tells whether one viewpoint moves the origin; `wanted` is what ChooseSceneOrigin returns.
    bool Moves(const glm::dvec3& current, const glm::dvec3& wanted);

  private:
    // Far viewpoints in a row; the first one moves the origin at once.
    uint32_t m_farCount = kFarViewpointsToMove;
};

}  // namespace raygraph
