// Derives from a picture's settings the color of all its light, for a white balance, whether the built-in
// studio lights the picture, and whether a ground hides the environment. Threads: pure functions, for any
// thread.
#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "base/api.h"
#include "editor/session/file/resume.h"
#include "editor/session/process_group.h"
#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/scene_input.h"
#include "renderer/gpu_scene/gpu_scene.h"

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

// Decides whether the built-in studio lights a picture: returns PictureSettings::light for a picture with
// these settings, never Auto. The resumed render decides, if there is one; else the scene in `input` before
// a session has taken it, which is the same for all times, cameras, sizes and samples. A picture with a
// background or a map, or one that shows no light, has no studio. In a group, each process makes the call,
// only the root has `resumed`, and all get its decision. Throws Error{Usage} for what scene::Check refuses.
RAYGRAPH_API DefaultLight ChooseLight(const SceneInput& input, const PictureSettings& settings,
                                      const ResumedRender* resumed = nullptr, ProcessGroup* group = nullptr);

// Returns the environment of a scene on a device, with or without a map of SceneInput::environment.
EnvironmentSettings EnvironmentOf(const PictureSettings& settings, bool hasMap);

// Hides the environment (`transparent`) if `given` turns the ground on and has no word of `transparent`.
// Returns whether it has: a display picture then has the environment as it is for a backdrop
// (SessionDesc::backdrop), so that only the ground's shadow is seen.
RAYGRAPH_API bool HideBehindGround(SettingTexts& given);

}  // namespace raygraph::session
