#include "renderer/gpu_scene/lights/alias_table.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "base/check.h"

namespace raygraph {

namespace {

// Returns a float that is 0 only for 0, because a probability of 0 tells that the outcome never occurs.
float Probability(double p) {
    return p > 0.0 ? std::max(static_cast<float>(p), std::numeric_limits<float>::min()) : 0.0f;
}

}  // namespace

double BuildAliasTable(std::span<const double> weights, std::span<gpu::AliasEntry> slots) {
    RG_CHECK_EQ(weights.size(), slots.size());
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    const auto count = static_cast<uint32_t>(weights.size());
    if (!(sum > 0.0)) {
        for (uint32_t i = 0; i < count; ++i) slots[i] = {.keep = 1.0f, .alias = i, .probability = 0.0f};
        return 0.0;
    }
    // The weight that each slot still has to distribute, in units of a slot
    std::vector<double> shares(count);
    std::vector<uint32_t> poor, rich;
    uint32_t heaviest = 0;
    for (uint32_t i = 0; i < count; ++i) {
        shares[i] = weights[i] / sum * count;
        slots[i] = {.keep = 1.0f, .alias = i, .probability = Probability(weights[i] / sum)};
        (shares[i] < 1.0 ? poor : rich).push_back(i);
        if (weights[i] > weights[heaviest]) heaviest = i;
    }
    while (!poor.empty() && !rich.empty()) {
        const uint32_t small = poor.back();
        const uint32_t large = rich.back();
        poor.pop_back();
        slots[small].keep = static_cast<float>(shares[small]);
        slots[small].alias = large;
        shares[large] -= 1.0 - shares[small];
        if (shares[large] < 1.0) {
            rich.pop_back();
            poor.push_back(large);
        }
    }
    // Rounding may leave slots that should be full, and an outcome without weight must not become one
    for (const uint32_t i : poor)
        if (weights[i] == 0.0) slots[i] = {.keep = 0.0f, .alias = heaviest, .probability = 0.0f};
    return sum;
}

}  // namespace raygraph
