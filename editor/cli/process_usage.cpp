#include "editor/cli/process_usage.h"

#include <sys/resource.h>

namespace raygraph::cli {

namespace {

rusage Usage() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage;
}

double Seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

double ProcessCpuSeconds() {
    const rusage usage = Usage();
    return Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
}

uint64_t PeakResidentBytes() {
    return uint64_t{1024} * static_cast<uint64_t>(Usage().ru_maxrss);  // Linux counts in KiB
}

}  // namespace raygraph::cli
