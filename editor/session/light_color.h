// The color of a scene's light, for a white balance. Threads: a pure function, for any thread.
#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "base/api.h"
#include "editor/session/picture_settings.h"
#include "editor/session/scene_input.h"

namespace raygraph::session {

// The power in W of all light that a picture of these settings has, linear Rec. 709: the sum over
//   surfaces that emit (unlit ones do not): pi A L, on either side that emits, with the mean of the whole
//     emissive texture, in the base shape of what is deformed;
//   point lights and spots: their intensity over all directions; directional ones: pi R^2 E;
//   the environment, be it the studio (ChooseLight): 4 pi^2 R^2 times its mean radiance over all directions;
// where R is the radius of the scene's bounds, or 1 m without any. It says nothing of what the camera sees.
// In the pose that `input` has; before a session has taken it. None: nothing emits.
RAYGRAPH_API std::optional<glm::dvec3> LightColor(const SceneInput& input, const PictureSettings& settings);

}  // namespace raygraph::session
