// The report of a render.
#pragma once

#include "editor/cli/arguments.h"
#include "editor/cli/report.h"
#include "editor/session/session.h"

namespace raygraph::cli {

// Everything but the settings. Renders one frame more, to count rays, where paths are traced.
Report DescribeRun(std::span<rhi::Device* const> devices, Session& session, const SessionResult& result,
                   const RunSummary& run);

}  // namespace raygraph::cli
