// The compressed wide tree (shaders/shared/wide_bvh.h) of a binary one, and its refit. Threads: pure
// functions; a WideRefit: one at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "renderer/bvh/binary_bvh.h"
#include "renderer/bvh/box.h"
#include "shaders/shared/wide_bvh.h"

namespace raygraph {

struct WideBvh {
    std::vector<gpu::WideNode> nodes;  // 0 is the root
    std::vector<uint32_t> primitives;  // in the order of the leaves
    uint32_t depth = 0;                // nodes from the root to the deepest one, both included
    // Is the expected cost of a ray that meets the root's box, by the boxes as stored: a node costs 1 and a
    // primitive kWidePrimitiveCost.
    double sahCost = 0.0;
};

inline constexpr float kWidePrimitiveCost = 0.3f;  // the paper's value

// Chooses by dynamic programming the nodes of the binary tree that become nodes and leaves, so that the cost
// is minimal. A tree without primitives has one node without children.
WideBvh CollapseToWide(const BinaryBvh& tree);

// Stores the boxes of a node whose children are known (`meta`, and which of them are nodes): its own, and one
// for each slot, where those of empty slots are ignored. All are finite.
void StoreBoxes(gpu::WideNode& node, const Box& box, std::span<const Box, gpu::kWideChildren> children);
// Returns what a node and its leaves add to sahCost, times the area of the root's box.
double CostOf(const gpu::WideNode& node, const Box& box);

// Returns the box of a child, as the shader has it; empty for an empty slot.
Box WideChildBox(const gpu::WideNode& node, uint32_t slot);
// Returns the byte of `meta` for a slot.
inline uint32_t WideMeta(const gpu::WideNode& node, uint32_t slot) {
    return node.meta[slot / 4] >> (8 * (slot % 4)) & 0xFFu;
}
inline bool IsWideNode(const gpu::WideNode& node, uint32_t slot) {
    return (node.exponents >> (24 + slot) & 1u) != 0u;
}

// WideRefit adapts the boxes of a wide tree to primitives that have moved. Its nodes and leaves stay, so
// that the tree becomes worse the farther primitives move relative to each other; Decay measures that.
class WideRefit {
  public:
    WideRefit() = default;
    // Returns the box of a primitive, by its index in the leaves. It must be finite.
    using BoxOf = std::function<Box(uint32_t primitive)>;
    // Takes a tree as CollapseToWide makes it: indices of children and primitives are relative to the tree's
    // own first ones.
    WideRefit(std::span<const gpu::WideNode> nodes, const BoxOf& boxOf);

    // Updates the nodes that contain the moved primitives, and returns their indices. The nodes then depend
    // only on where all primitives are now, not on earlier refits.
    std::vector<uint32_t> Refit(std::span<gpu::WideNode> nodes, std::span<const uint32_t> moved,
                                const BoxOf& boxOf);
    // Returns the expected cost of rays of a given density in space, which is in proportion to the areas of
    // boxes, divided by that when the tree was made.
    double Decay() const;
    // Returns the box around all primitives.
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
    std::vector<uint32_t> m_nodeOf;  // indexed by primitive
    double m_cost = 0.0, m_costMade = 0.0;
};

}  // namespace raygraph
