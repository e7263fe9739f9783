// A balanced tree of boxes over leaves in a fixed order. It stands for the tree that a driver has built over
// the instances of a TLAS and since then only updated: the same order, and boxes that fit what is below them
// now. A change costs time in proportion to the leaves that have changed. Threads: as std::vector.
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

    // Replaces all leaves. Empty boxes are legal, and count for nothing.
    void Assign(std::span<const scene::Bounds> leaves);
    // Adds empty leaves behind the others, up to this number. On an exception nothing has changed.
    void Grow(size_t leafCount);
    // Boxes above the leaf are those from before until Refresh.
    void Set(size_t leaf, const scene::Bounds& box) noexcept;
    void Refresh() noexcept;
    // Before a Set that comes soon: fetches what it and Refresh read.
    void Prefetch(size_t leaf) const {
        const auto* const family = reinterpret_cast<const char*>(&m_levels[0].families[leaf / kChildren]);
        for (size_t byte = 0; byte < sizeof(Family); byte += 64) __builtin_prefetch(family + byte);
    }

    size_t LeafCount() const { return m_levels.empty() ? 0 : m_levels[0].count; }
    // Leaves that are not empty.
    size_t BoxCount() const { return m_boxCount; }
    // Around all leaves.
    scene::Bounds Root() const;
    // The sum of the surface areas of the boxes between the leaves and the root, which are those that another
    // order would change: proportional to the number of them that a random ray meets. Each box knows the sum
    // of what is below it, so that no error remains of what has been there before.
    double Cost() const { return m_levels.size() < 2 ? 0.0 : m_levels[m_levels.size() - 2].CostOf(0); }

  private:
    // The boxes of one parent; empty ones where there are no more.
    struct alignas(64) Family {
        std::array<scene::Bounds, kChildren> boxes;
        scene::Bounds Around() const;
    };
    struct Level {
        size_t count = 0;  // of boxes
        LargeArray<Family> families;
        std::vector<double> costs;   // by box: its area and those of the boxes below it. None of leaves
        std::vector<uint32_t> due;   // families in which a box has changed; as much room as there are
        std::vector<uint8_t> isDue;  // these
        scene::Bounds& Box(size_t i) { return families[i / kChildren].boxes[i % kChildren]; }
        const scene::Bounds& Box(size_t i) const { return families[i / kChildren].boxes[i % kChildren]; }
        double CostOf(size_t family) const;  // of its boxes
        void MarkDirty(size_t family) noexcept;
        void Reserve(size_t boxes);
        void Resize(size_t boxes, bool isLeaves);  // has room
    };

    std::vector<Level> m_levels;  // the leaves first, one box last
    size_t m_boxCount = 0;
};

}  // namespace raygraph
