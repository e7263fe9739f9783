// A balanced tree of boxes over leaves in a fixed order. It stands for the tree that a driver has built over
// the instances of a TLAS and since then only updated: the same order, and boxes that fit what is below them
// now. A change costs time in proportion to the leaves that have changed. Threads: as std::vector.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/mesh_data.h"

namespace raygraph {

class BoxTree {
  public:
    static constexpr size_t kChildren = 8;

    // Replaces all leaves. Empty boxes are legal, and count for nothing.
    void Assign(std::vector<scene::Bounds> leaves);
    // Boxes above the leaf are those from before until Refresh.
    void Set(size_t leaf, const scene::Bounds& box);
    void Refresh();
    // Before a Set that comes soon: fetches what it and Refresh read.
    void Prefetch(size_t leaf) const;

    size_t LeafCount() const { return m_levels.empty() ? 0 : m_levels[0].boxes.size(); }
    // Around all leaves.
    scene::Bounds Root() const;
    // The sum of the surface areas of the boxes between the leaves and the root, which are those that another
    // order would change: proportional to the number of them that a random ray meets.
    double Cost() const { return m_cost; }

  private:
    struct Level {
        std::vector<scene::Bounds> boxes;
        std::vector<bool> isDue;    // a child has changed
        std::vector<uint32_t> due;  // these
    };
    void MarkDue(Level& level, size_t box);
    bool IsCounted(size_t level) const { return level > 0 && level + 1 < m_levels.size(); }

    std::vector<Level> m_levels;  // the leaves first, one box last
    double m_cost = 0.0;
};

}  // namespace raygraph
