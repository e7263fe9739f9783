// WideRefit adapts the boxes of a wide tree to primitives that have moved. Its nodes and leaves stay, so that
// the tree becomes worse the farther primitives move relative to each other; Decay measures that. Threads:
// one at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "renderer/bvh/box.h"
#include "shaders/shared/wide_bvh.h"

namespace raygraph {

class WideRefit {
  public:
    WideRefit() = default;
    // The box of a primitive, by its place in the leaves; finite.
    using BoxOf = std::function<Box(uint32_t primitive)>;
    // Takes a tree as CollapseToWide makes it: indices of children and primitives are relative to the tree's
    // own first ones.
    WideRefit(std::span<const gpu::WideNode> nodes, const BoxOf& boxOf);

    // Updates the nodes that contain the moved primitives, and returns their indices. The nodes then depend
    // only on where all primitives are now, not on earlier refits.
    std::vector<uint32_t> Refit(std::span<gpu::WideNode> nodes, std::span<const uint32_t> moved,
                                const BoxOf& boxOf);
    // The expected cost of rays of a given density in space, which is in proportion to the areas of boxes,
    // over that when the tree was made.
    double Decay() const;
    // The box around all primitives.
    const Box& Bounds() const { return m_nodes.front().box; }

  private:
    struct Node {
        Box box;
        uint32_t parent = 0;
        double cost = 0.0;  // SAH cost of the node and its leaves
        bool isDirty = false;
    };
    void Store(std::span<gpu::WideNode> nodes, uint32_t node, const BoxOf& boxOf);

    std::vector<Node> m_nodes;
    std::vector<uint32_t> m_nodeOf;  // by primitive
    double m_cost = 0.0, m_costMade = 0.0;
};

}  // namespace raygraph
