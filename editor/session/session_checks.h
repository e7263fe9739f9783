// What a session refuses before it begins. For editor/session/ alone. Threads: pure functions.
#pragma once

#include <string>

#include "editor/session/session.h"

namespace raygraph::session {

// Error{Usage}: "Session: " and why.
[[noreturn]] void Refuse(const std::string& why);

// Throws as the constructor of Session says, for what can be told without a scene.
void RequirePossible(const SessionDesc& desc);

// The same, of a picture of that many devices.
void RequireAdaptive(const SessionDesc& desc, size_t deviceCount);

// The same for a resumed render, of a session whose render is `described`.
void RequireSame(const ResumedRender& resumed, const RenderFile& described);

// For a run of a picture that has `before` samples from `firstSample` on.
void RequireRule(const StopRule& rule, uint32_t firstSample, uint32_t before, bool canEstimateError);

}  // namespace raygraph::session
