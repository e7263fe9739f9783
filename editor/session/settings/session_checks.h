// Checks what a session refuses before it begins, and what is asked for beside a render to resume. Threads:
// pure functions.
#pragma once

#include <string>

#include "base/api.h"
#include "editor/session/session.h"

namespace raygraph::session {

// Throws Error{Usage} with the text "Session: " and the reason.
[[noreturn]] void Reject(const std::string& why);

// Throws as the constructor of Session does, for what can be checked without a scene.
void RequireValidDesc(const SessionDesc& desc);

// Does so for an adaptive picture on so many devices.
void RequireAdaptive(const SessionDesc& desc, size_t deviceCount);
// Refuses what the denoiser cannot do.
void RequireDenoisable(const SessionDesc& desc, size_t deviceCount);

// Does so for a resumed render in a session whose render is `described`.
void RequireSame(const ResumedRender& resumed, const RenderFile& described);

// Returns the settings with which a render goes on: its own, with those of `given` that it leaves open.
// Throws SettingError of kind Usage, "max-depth 4: a.exr was rendered with 8", for one of `given` that
// differs.
RAYGRAPH_API PictureSettings SettingsToResume(const ResumedRender& resumed, const SettingTexts& given);
// Throw such an Error for AOVs and a first sample that are given and are not those of the render.
RAYGRAPH_API void RequireAovs(const ResumedRender& resumed, const AovSet& given);
RAYGRAPH_API void RequireFirstSample(const ResumedRender& resumed, uint32_t given);

// Checks the rule of a run of a picture that has `before` samples from `firstSample` on.
void RequireValidRule(const StopRule& rule, uint32_t firstSample, uint32_t before, bool canEstimateError);

}  // namespace raygraph::session
