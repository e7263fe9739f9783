// Makes the report of a render.
#pragma once

#include "editor/cli/arguments.h"
#include "editor/cli/report.h"
#include "editor/session/session.h"

namespace raygraph::cli {

// Fills in everything but the settings. It renders one extra frame to count rays if paths are traced.
Report DescribeRun(std::span<rhi::Device* const> devices, Session& session, const SessionResult& result,
                   const RunSummary& run);

}  // namespace raygraph::cli
