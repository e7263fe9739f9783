// How much a tree over triangles has decayed by refits: the measure by which a deforming BLAS is rebuilt.
//
// The driver's tree is not to be seen, so a tree over a sample of the triangles stands for it: balanced, over
// their order along a space-filling curve. Its cost is the sum of the surface areas of its boxes, which is
// proportional to the boxes that a random ray meets. The decay is the cost of the tree with the order of the
// last build over that of a tree with the order of the triangles where they are now: what a rebuild would
// gain. A mesh that only moves, turns, stretches or bends as a whole keeps about 1. Threads: as std::vector.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace raygraph {

class RefitQuality {
  public:
    // A copy is rebuilt where the decay is above this.
    static constexpr float kMaxDecay = 1.25f;
    // Triangles of a group in the sample.
    static constexpr size_t kSampleCount = 128;

    // The triangles are here now: `corners`, three each, always as many. Returns the decay; 1 before the
    // first build, and without triangles.
    float Follow(std::span<const glm::vec3> corners);
    // The triangles were built where they are now. Takes no memory: frames say so once they are submitted,
    // when nothing may fail.
    void OnBuild() noexcept;

  private:
    std::vector<uint32_t> m_order;         // of the last build
    std::vector<uint32_t> m_currentOrder;  // of the triangles where they are now
};

}  // namespace raygraph
