// The description of a pipeline of the graph, with its driver's statistics. Threads: plain values.
#pragma once

#include <string>
#include <vector>

#include "rhi/pipeline.h"

namespace raygraph {

struct PipelineReport {
    // Name of its first shader; several pipelines may differ in their specialization alone.
    std::string name;
    double creationMs = 0.0;  // wall time of the creation by the driver
    std::vector<rhi::ProgramStatistics> programs;
};

}  // namespace raygraph
