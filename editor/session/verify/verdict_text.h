// Verdicts as text. Threads: pure functions, for any thread.
#pragma once

#include <string>

#include "base/api.h"
#include "editor/session/verify/verify.h"

namespace raygraph::session {

// Returns lines: the verdict on the picture of this name, each check that failed, and what may be off.
// `found` stands for "right" or "NOT RIGHT", if it is not empty. The last line says it if more samples of the
// reference could change the verdict.
RAYGRAPH_API std::string Describe(const VerifyResult& result, const std::string& name,
                                  const std::string& found = {});

}  // namespace raygraph::session
