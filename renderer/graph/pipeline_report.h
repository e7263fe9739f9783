// The description of a pipeline of the graph, with its driver's statistics. Threads: plain values.
#pragma once

#include <string>
#include <vector>

#include "rhi/pipeline_statistics.h"

namespace raygraph {

struct PipelineReport {
    std::string name;         // name of its first shader; several may differ in specialization only
    double creationMs = 0.0;  // wall time that the driver took
    std::vector<rhi::ProgramStatistics> programs;
};

}  // namespace raygraph
