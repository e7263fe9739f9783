// A balanced tree of boxes over leaves in a fixed order. It models the tree that a driver has built over the
// instances of a TLAS and has only updated since then: the order is the same, and each box fits what is below
// it now. The time of a change is in proportion to the number of leaves that have changed. Threads: as
// std::vector.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/large_pages.h"
#include "renderer/scene/model/mesh_data.h"

namespace raygraph {

class BoxTree {
  public:
    static constexpr size_t kChildren = 8;

    // Replaces all leaves. Empty boxes are legal and are ignored.
    void Assign(std::span<const scene::Bounds> leaves);
    // Appends empty leaves up to `leafCount`. On an exception nothing has changed.
    void Grow(size_t leafCount);
    // The boxes above the leaf are updated by Refresh.
    void Set(size_t leaf, const scene::Bounds& box) noexcept;
    void Refresh() noexcept;
    // Fetches into the cache what the next Set of this leaf, and Refresh, will read.
    void Prefetch(size_t leaf) const {
        const auto* const family = reinterpret_cast<const char*>(&m_levels[0].families[leaf / kChildren]);
        for (size_t byte = 0; byte < sizeof(Family); byte += 64) __builtin_prefetch(family + byte);
    }

    size_t LeafCount() const { return m_levels.empty() ? 0 : m_levels[0].count; }
    // Returns the number of leaves that are not empty.
    size_t BoxCount() const { return m_boxCount; }
    // Returns the box around all leaves.
    scene::Bounds Root() const;
    // Returns the sum of the surface areas of the boxes between the leaves and the root, which is
    // proportional to how many of them a random ray meets. Another order of the leaves would change these
    // boxes alone. Each box stores the sum of what is below it, so that rounding errors do not accumulate
    // over changes.
    double Cost() const { return m_levels.size() < 2 ? 0.0 : m_levels[m_levels.size() - 2].CostOf(0); }

  private:
    // The boxes of one parent. Missing children have empty boxes.
    struct alignas(64) Family {
        std::array<scene::Bounds, kChildren> boxes;
        scene::Bounds Around() const;
    };
    struct Level {
        size_t count = 0;  // number of boxes
        LargeArray<Family> families;
        std::vector<double> costs;   // by box: its area plus those of all boxes below it; empty for leaves
        std::vector<uint32_t> due;   // families with a changed box; its capacity is the number of families
        std::vector<uint8_t> isDue;  // by family: whether it is listed in `due`
        scene::Bounds& Box(size_t i) { return families[i / kChildren].boxes[i % kChildren]; }
        const scene::Bounds& Box(size_t i) const { return families[i / kChildren].boxes[i % kChildren]; }
        double CostOf(size_t family) const;  // sum over the family's boxes
        void MarkDirty(size_t family) noexcept;
        void Reserve(size_t boxes);
        void Resize(size_t boxes, bool isLeaves);  // within the reserved capacity
    };

    std::vector<Level> m_levels;  // the leaves are first, the root is last
    size_t m_boxCount = 0;
};

}  // namespace raygraph
