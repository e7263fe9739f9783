// TracingChoice selects who traces a picture's rays, and the form of the integrator: by rules, unless a
// measurement wants otherwise. Threads: pure functions, except for ChooseTracing.
#pragma once

#include <string>

#include "base/api.h"
#include "editor/session/frames/pass_times.h"
#include "passes/trace.h"

namespace raygraph::session {

// Applies to a picture on all its devices. It is no setting of the picture: all choices give the same
// picture, up to rounding.
struct TracingChoice {
    Traversal traversal = Traversal::Auto;
    passes::IntegratorForm form = passes::IntegratorForm::Auto;

    bool operator==(const TracingChoice&) const = default;
};

// Returns `asked` with the faster choice on this device for what it leaves open (FasterTraversal,
// passes::DefaultForm). Threads: that of the device's Renderers.
RAYGRAPH_API TracingChoice ChooseTracing(rhi::Device& device, const TracingChoice& requested);

// Returns the sum of the medians of Trace's passes in a frame, in any form.
RAYGRAPH_API double MsOfTrace(const PassTimes& times);

// Warns that software traversal was asked for and is not possible.
RAYGRAPH_API void WarnDriverTraversal(const Log& log, const std::string& driverTraversalReason);

}  // namespace raygraph::session
