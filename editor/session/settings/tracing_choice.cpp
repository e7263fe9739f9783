#include "editor/session/settings/tracing_choice.h"

#include "base/log.h"
#include "base/text.h"

namespace raygraph::session {

TracingChoice ChooseTracing(rhi::Device& device, const TracingChoice& requested) {
    TracingChoice chosen = requested;
    if (chosen.traversal == Traversal::Auto) chosen.traversal = FasterTraversal(device);
    if (chosen.form == passes::IntegratorForm::Auto) chosen.form = passes::DefaultForm(device);
    return chosen;
}

double MsOfTrace(const PassTimes& times) {
    double sum = 0.0;
    for (const PassTime& pass : times.Summary())
        sum += passes::IsTracePass(pass.name) ? pass.gpuMsMedian : 0.0;
    return sum;
}

void WarnDriverTraversal(const Log& log, const std::string& driverTraversalReason) {
    WriteLog(log, LogLevel::Warning, log_category::kScene,
             "the driver's traversal is used in place of Raygraph's own: {}", driverTraversalReason);
}

}  // namespace raygraph::session
