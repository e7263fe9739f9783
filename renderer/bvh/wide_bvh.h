// The compressed wide tree (shaders/shared/wide_bvh.h) of a binary one. Threads: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/bvh/binary_bvh.h"
#include "shaders/shared/wide_bvh.h"

namespace raygraph {

struct WideBvh {
    std::vector<gpu::WideNode> nodes;  // 0 is the root
    std::vector<uint32_t> primitives;  // in the order of the leaves
    uint32_t depth = 0;                // nodes from the root to the deepest one, both included
    // The expected cost of a ray that meets the root's box, by the boxes as stored: a node costs 1 and a
    // primitive kWidePrimitiveCost.
    double sahCost = 0.0;
};

inline constexpr float kWidePrimitiveCost = 0.3f;  // as in the paper

// Chooses by dynamic programming the nodes of the binary tree that become nodes and leaves, so that the cost
// is minimal. A tree without primitives has one node without children.
WideBvh CollapseToWide(const BinaryBvh& tree);

// Stores the boxes of a node whose children are known (`meta`, and which of them are nodes): its own, and one
// for each slot, where those of empty slots are ignored. All are finite.
void StoreBoxes(gpu::WideNode& node, const Box& box, std::span<const Box, gpu::kWideChildren> children);
// Returns what a node and its leaves add to sahCost, times the area of the root's box.
double CostOf(const gpu::WideNode& node, const Box& box);

// The box of a child, as the shader has it; empty for an empty slot.
Box WideChildBox(const gpu::WideNode& node, uint32_t slot);
// Returns the byte of `meta` for a slot.
inline uint32_t WideMeta(const gpu::WideNode& node, uint32_t slot) {
    return node.meta[slot / 4] >> (8 * (slot % 4)) & 0xFFu;
}
inline bool IsWideNode(const gpu::WideNode& node, uint32_t slot) {
    return (node.exponents >> (24 + slot) & 1u) != 0u;
}

}  // namespace raygraph
