// BoundsTree: the box around many boxes, of which few change at a time.
//
// Threads: plain values.
#pragma once

#include <cstddef>
#include <vector>

#include "base/api.h"
#include "renderer/scene/model/mesh_data.h"

namespace raygraph::scene {

// A binary tree in an array: the box at i is around those at 2 i and 2 i + 1, the leaves come last.
class RAYGRAPH_API BoundsTree {
  public:
    // Sets the count of boxes, all empty.
    void Assign(size_t count) { m_boxes.assign(2 * count, {}); }
    size_t Count() const { return m_boxes.size() / 2; }

    // Sets one box. Takes time logarithmic in the count, less if All does not change.
    void Set(size_t index, const Bounds& box) {
        size_t i = Count() + index;
        m_boxes[i] = box;
        for (i /= 2; i > 0; i /= 2) {
            const Bounds around = Around(i);
            if (around.min == m_boxes[i].min && around.max == m_boxes[i].max) return;
            m_boxes[i] = around;
        }
    }
    // To set many: SetLeaf for each, then Update once, whose time is proportional to the number of leaves.
    void SetLeaf(size_t index, const Bounds& box) { m_boxes[Count() + index] = box; }
    void Update() {
        for (size_t i = Count(); i-- > 1;) m_boxes[i] = Around(i);
    }
    // Returns the box around all; empty boxes do not count.
    Bounds All() const {
        if (m_boxes.size() < 2) return {};
        return m_boxes[1];
    }

  private:
    Bounds Around(size_t i) const {
        Bounds box = m_boxes[2 * i];
        box.Extend(m_boxes[2 * i + 1]);
        return box;
    }

    std::vector<Bounds> m_boxes;
};

}  // namespace raygraph::scene
