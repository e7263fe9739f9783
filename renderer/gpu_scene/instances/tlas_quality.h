// When a TLAS that has only been updated is rebuilt. An update keeps the tree and changes its boxes: where
// instances have moved away from their neighbors in the tree, the boxes are large, and rays meet many of
// them.
//
// The TLAS is rebuilt in a new order when the tree has decayed, and the time lost by this has reached the
// time of a rebuild.
//
// Decay: how many boxes a random ray meets for each visible instance, divided by the smallest such number
// since the last build. Drivers do not expose their trees, so BoxTree::Cost models the number. Above
// kMaxDecay the tree has decayed. Hence instances that move or turn as a whole cause no decay; a set that
// spreads is rebuilt each time that it has spread by this factor; and if a build was bad because one instance
// was far away, it is no longer the measure once that returns.
//
// Cost: each frame since the build has lost Decay - 1 of the time that it would have taken to trace. A
// rebuild takes time in proportion to the instances, and kInstancesPerFrame of them are taken to cost as much
// as a frame. Hence a small scene is rebuilt at once, and a large one in which few instances travel far only
// after many frames.
//
// Added instances follow all others in the order, and removed ones leave gaps: either may be one part in
// kMaxChanged of the instances before all get a new order. Threads: plain values.
#pragma once

#include <algorithm>
#include <cstdint>

namespace raygraph {

class TlasQuality {
  public:
    static constexpr double kMaxDecay = 1.25;
    static constexpr double kInstancesPerFrame = 10'000.0;
    static constexpr uint64_t kMaxChanged = 4;
    static constexpr uint64_t kFewChanged = 64;  // this many are always allowed

    void OnBuild(double cost, uint64_t instanceCount) {
        m_best = PerInstance(cost, instanceCount);
        m_lostFrames = 0.0;
    }
    // Must be called once for each frame that traces the current tree. Returns true if it should be rebuilt
    // first.
    bool UpdateDecay(double cost, uint64_t instanceCount) {
        const double now = PerInstance(cost, instanceCount);
        // Points, and instances that were hidden when the tree was built, have no size to compare with
        if (m_best <= 0.0) return now > 0.0;
        if (now > 0.0) m_best = std::min(m_best, now);
        const double decay = now / m_best;
        m_lostFrames += std::max(0.0, decay - 1.0);
        return decay > kMaxDecay && m_lostFrames * kInstancesPerFrame >= static_cast<double>(instanceCount);
    }
    // Tells whether the number of instances added since the last order, or of gaps, is too large.
    static bool IsTooMany(uint64_t changed, uint64_t instanceCount) {
        return changed > kFewChanged && changed > instanceCount / kMaxChanged;
    }

  private:
    static double PerInstance(double cost, uint64_t count) {
        return count > 0 ? cost / static_cast<double>(count) : 0.0;
    }

    double m_best = 0.0;
    double m_lostFrames = 0.0;
};

}  // namespace raygraph
