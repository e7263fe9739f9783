// Measures how much a tree over triangles has decayed by refits. A deforming BLAS is rebuilt by this measure.
//
// The driver's tree cannot be inspected, so a tree over a sample of the triangles models it: a balanced one
// over their order along a space-filling curve. Its cost is the sum of the surface areas of its boxes, which
// is proportional to how many boxes a random ray meets. The decay is the cost with the order of the last
// build, divided by the cost with the order of the triangles as they are now, which a rebuild would restore.
// It stays near 1 for a mesh that only moves, turns, stretches or bends as a whole. Threads: as std::vector.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace raygraph {

class RefitQuality {
  public:
    // A copy is rebuilt when its decay exceeds this.
    static constexpr float kMaxDecay = 1.25f;
    // Number of triangles of a group in the sample.
    static constexpr size_t kSampleCount = 128;

    // Sets the current triangles: three corners each, and the same number in every call. Returns the decay,
    // which is 1 before the first build and without triangles.
    float Follow(std::span<const glm::vec3> corners);
    // Records that the BLAS has been built from the current triangles. It allocates nothing, because it is
    // called once a frame has been submitted, when no call may fail.
    void OnBuild() noexcept;

  private:
    std::vector<uint32_t> m_order;         // order at the last build
    std::vector<uint32_t> m_currentOrder;  // order of the triangles as they are now
};

}  // namespace raygraph
