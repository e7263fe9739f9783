// When a TLAS that has only been updated is rebuilt. An update keeps the tree and changes its boxes: where
// instances have parted from their neighbors in the tree, the boxes are large, and rays meet many of them.
//
// The rule: a rebuild where the tree has decayed, and has cost as much as a rebuild does.
//   Decay: the boxes that a random ray meets, over those that it met after the last build. Drivers do not
//   show their trees: BoxTree::Cost stands for that number. Above kMaxDecay the tree has decayed. So what
//   moves or is turned as a whole never decays; what spreads is rebuilt when it has spread by as much again.
//   Cost: each frame since then has lost Decay - 1 of the time that it would have taken to trace. A rebuild
//   takes time in proportion to the instances, which is put at that of a frame for kInstancesPerFrame of
//   them. So a small scene is rebuilt at once, and a large one in which a few travel far only after many
//   frames.
#pragma once

#include <algorithm>
#include <cstdint>

namespace raygraph {

class TlasQuality {
  public:
    static constexpr double kMaxDecay = 1.25;
    static constexpr double kInstancesPerFrame = 10'000.0;

    void NoteBuild(double cost) {
        m_builtCost = cost;
        m_lostFrames = 0.0;
    }
    // A frame that traces the tree as it is now. True: it should be rebuilt before.
    bool NoteFrame(double cost, uint64_t instanceCount) {
        // Points, and what was hidden when the tree was built, have no size to compare with
        if (m_builtCost <= 0.0) return cost > 0.0;
        const double decay = cost / m_builtCost;
        m_lostFrames += std::max(0.0, decay - 1.0);
        return decay > kMaxDecay && m_lostFrames * kInstancesPerFrame >= static_cast<double>(instanceCount);
    }

  private:
    double m_builtCost = 0.0;
    double m_lostFrames = 0.0;
};

}  // namespace raygraph
