// Computes the color of a scene's light, for a white balance. Threads: a pure function, for any thread.
#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "base/api.h"
#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/scene_input.h"

namespace raygraph::session {

// Returns the power in W of all light in a picture with these settings, linear Rec. 709: the sum over
//   surfaces that emit (unlit ones do not): pi A L, on either side that emits, with the mean of the whole
//     emissive texture, in the base shape of what is deformed;
//   point lights and spots: their intensity over all directions; directional ones: pi R^2 E;
//   the environment, be it the studio (ChooseLight): 4 pi^2 R^2 times its mean radiance over all directions;
// where R is the radius of the scene's bounds, or 1 m without any. It does not depend on what the camera
// sees.
// It is of the pose in `input`, before a session has taken it. None: nothing emits.
RAYGRAPH_API std::optional<glm::dvec3> LightColor(const SceneInput& input, const PictureSettings& settings);

}  // namespace raygraph::session
