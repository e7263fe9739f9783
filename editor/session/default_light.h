// Whether the built-in studio lights a picture. Threads: a pure function, for any thread.
#pragma once

#include "base/api.h"
#include "editor/session/picture_settings.h"
#include "editor/session/process_group.h"
#include "editor/session/resume.h"
#include "editor/session/scene_input.h"

namespace raygraph::session {

// What PictureSettings::light is for a picture of these settings: never Auto. That is decided by the resumed
// render, if there is one; else by the scene as `input` has it before a session has taken it, which is the
// same for all times, cameras, sizes and samples. A picture that has a background or a map, or that shows no
// light, has no studio. Of a group each process makes the call, the root alone has `resumed`, and all get
// what it decides. Error{Usage} for what scene::Check refuses.
RAYGRAPH_API DefaultLight ChooseLight(const SceneInput& input, const PictureSettings& settings,
                                      const ResumedRender* resumed = nullptr, ProcessGroup* group = nullptr);

}  // namespace raygraph::session
