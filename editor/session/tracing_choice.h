// Who traces a picture's rays, and in which form of the integrator: by rules, unless a measurement wants it
// otherwise. Threads: pure functions, but for ChooseTracing.
#pragma once

#include <string>

#include "base/api.h"
#include "editor/session/pass_times.h"
#include "passes/trace.h"

namespace raygraph::session {

// Of one picture on all its devices. It is no setting of the picture: all choices give one picture, but for
// rounding.
struct TracingChoice {
    Traversal traversal = Traversal::Auto;
    passes::IntegratorForm form = passes::IntegratorForm::Auto;

    bool operator==(const TracingChoice&) const = default;
};

// `asked`, with what it leaves open as is faster on the device (FasterTraversal, passes::FormOn). Threads:
// that of the device's Renderers.
RAYGRAPH_API TracingChoice ChooseTracing(rhi::Device& device, const TracingChoice& asked);

// Of the passes of Trace in a frame, in any form: the sum of their medians.
RAYGRAPH_API double MsOfTrace(const PassTimes& times);

// Says that own traversal was asked for and is not possible.
RAYGRAPH_API void WarnOfDriver(const Log& log, const std::string& whyNotOwn);

}  // namespace raygraph::session
