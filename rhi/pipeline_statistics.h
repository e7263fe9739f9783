// Statistics of the programs that a driver has compiled from a pipeline's shaders: registers, stack memory,
// occupancy. Names and units are the driver's. Threads: any.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/api.h"

namespace raygraph::rhi {

class Device;
class Pipeline;

struct ProgramStatistic {
    std::string name;         // "Register Count"
    std::string description;  // a sentence
    double value = 0.0;       // 1 or 0 for a boolean
};

struct ProgramStatistics {
    std::string name;           // the driver's name of the program: "RAY GENERATION"
    uint32_t subgroupSize = 0;  // 0: unknown
    std::vector<ProgramStatistic> statistics;
};

// Returns nothing unless DeviceDesc::capturesStatistics was set and the device supports it
// (OptionalFeatures::pipelineStatistics), and nothing for an empty pipeline. Throws Error{Vulkan} or
// {OutOfMemory} from the driver.
RAYGRAPH_API std::vector<ProgramStatistics> StatisticsOf(const Device& device, const Pipeline& pipeline);

}  // namespace raygraph::rhi
