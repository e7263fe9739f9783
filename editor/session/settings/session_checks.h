// Checks what a session refuses before it begins. For editor/session/ alone. Threads: pure functions.
#pragma once

#include <string>

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

// Checks the rule of a run of a picture that has `before` samples from `firstSample` on.
void RequireValidRule(const StopRule& rule, uint32_t firstSample, uint32_t before, bool canEstimateError);

}  // namespace raygraph::session
