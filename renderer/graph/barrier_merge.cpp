#include "renderer/graph/barrier_merge.h"

#include <algorithm>

namespace raygraph {

namespace {

// Returns whether two barriers differ at most in their subresources. Transfers of ownership stay apart, since
// the two barriers of one must name the same part.
bool AreAlike(const PlannedBarrier& a, const PlannedBarrier& b) {
    if (a.srcQueueFamily != VK_QUEUE_FAMILY_IGNORED || b.srcQueueFamily != VK_QUEUE_FAMILY_IGNORED)
        return false;
    return a.dependency == b.dependency && a.predecessor == b.predecessor &&
           a.followsLastFrame == b.followsLastFrame;
}

}  // namespace

void AddBarrier(std::vector<PlannedBarrier>& barriers, size_t first, const PlannedBarrier& barrier) {
    if (!barrier.dependency.isNeeded) return;
    if (barriers.size() > first) {
        Subresources& last = barriers.back().part;
        if (last.layer == barrier.part.layer && last.level + last.levelCount == barrier.part.level &&
            AreAlike(barriers.back(), barrier)) {
            ++last.levelCount;
            return;
        }
    }
    barriers.push_back(barrier);
}

void MergeLayers(std::vector<PlannedBarrier>& barriers, size_t first) {
    if (barriers.size() < first + 2) return;
    size_t kept = first;
    for (size_t b = first; b < barriers.size(); ++b) {
        const PlannedBarrier barrier = barriers[b];
        const auto isBefore = [&](const PlannedBarrier& other) {
            return other.part.level == barrier.part.level &&
                   other.part.levelCount == barrier.part.levelCount &&
                   other.part.layer + other.part.layerCount == barrier.part.layer && AreAlike(other, barrier);
        };
        const auto end = barriers.begin() + static_cast<ptrdiff_t>(kept);
        const auto before = std::find_if(barriers.begin() + static_cast<ptrdiff_t>(first), end, isBefore);
        if (before != end)
            ++before->part.layerCount;
        else
            barriers[kept++] = barrier;
    }
    barriers.resize(kept);
}

}  // namespace raygraph
