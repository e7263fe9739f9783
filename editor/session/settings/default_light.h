// Decides whether the built-in studio lights a picture. Threads: a pure function, for any thread.
#pragma once

#include "base/api.h"
#include "editor/session/file/resume.h"
#include "editor/session/process_group.h"
#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/scene_input.h"

namespace raygraph::session {

// Returns PictureSettings::light for a picture with these settings, never Auto. The resumed render decides,
// if there is one; else the scene in `input` before a session has taken it, which is the same for all times,
// cameras, sizes and samples. A picture with a background or a map, or one that shows no light, has no
// studio. In a group, each process makes the call, only the root has `resumed`, and all get its decision.
// Throws Error{Usage} for what scene::Check refuses.
RAYGRAPH_API DefaultLight ChooseLight(const SceneInput& input, const PictureSettings& settings,
                                      const ResumedRender* resumed = nullptr, ProcessGroup* group = nullptr);

}  // namespace raygraph::session
