// When a TLAS that has only been updated is rebuilt. An update keeps the tree and changes its boxes: where
// instances have parted from their neighbors in the tree, the boxes are large, and rays meet many of them.
//
// The rule: a rebuild in a new order where the tree has decayed, and has cost as much as a rebuild does.
//   Decay: the boxes that a random ray meets, over the fewest that it has met since the last build, for each
//   instance that is seen. Drivers do not show their trees: BoxTree::Cost stands for that number. Above
//   kMaxDecay the tree has decayed. So what moves or is turned as a whole never decays; what spreads is
//   rebuilt when it has spread by as much again; and a build that was bad because something was far away
//   counts no longer when that comes back.
//   Cost: each frame since then has lost Decay - 1 of the time that it would have taken to trace. A rebuild
//   takes time in proportion to the instances, which is put at that of a frame for kInstancesPerFrame of
//   them. So a small scene is rebuilt at once, and a large one in which a few travel far only after many
//   frames.
// What was added stands behind all others in the order, and what was removed leaves gaps: either may be one
// part in kMaxChanged of the instances before all get a new order.
#pragma once

#include <algorithm>
#include <cstdint>

namespace raygraph {

class TlasQuality {
  public:
    static constexpr double kMaxDecay = 1.25;
    static constexpr double kInstancesPerFrame = 10'000.0;
    static constexpr uint64_t kMaxChanged = 4;
    static constexpr uint64_t kFewChanged = 64;  // so many are always allowed

    void OnBuild(double cost, uint64_t instanceCount) {
        m_best = PerInstance(cost, instanceCount);
        m_lostFrames = 0.0;
    }
    // A frame that traces the tree as it is now. True: it should be rebuilt before.
    bool UpdateDecay(double cost, uint64_t instanceCount) {
        const double now = PerInstance(cost, instanceCount);
        // Points, and what was hidden when the tree was built, have no size to compare with
        if (m_best <= 0.0) return now > 0.0;
        if (now > 0.0) m_best = std::min(m_best, now);
        const double decay = now / m_best;
        m_lostFrames += std::max(0.0, decay - 1.0);
        return decay > kMaxDecay && m_lostFrames * kInstancesPerFrame >= static_cast<double>(instanceCount);
    }
    // Whether so many that were added since the last order, or so many gaps, are too many.
    static bool AreMany(uint64_t changed, uint64_t instanceCount) {
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
