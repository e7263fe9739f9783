// Median returns the median of measured values. Threads: any.
#pragma once

#include <algorithm>
#include <vector>

namespace raygraph {

// Returns the middle value, the mean of the two middle ones for an even count; 0 for no values.
inline double Median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    std::ranges::sort(values);
    const size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

}  // namespace raygraph
