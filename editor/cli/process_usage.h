// What this process has used, as the system counts it.
#pragma once

#include <cstdint>

namespace raygraph::cli {

// Processor time of all threads, user and system, seconds. A CPU driver renders in this process.
double ProcessCpuSeconds();
// The most memory resident so far.
uint64_t PeakResidentBytes();

}  // namespace raygraph::cli
