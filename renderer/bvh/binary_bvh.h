// A binary tree of boxes by the surface area heuristic, the input of renderer/bvh/wide_bvh.h. Threads: pure
// functions, which use threads of their own; the tree does not depend on how many.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/bvh/box.h"

namespace raygraph {

struct BinaryNode {
    Box box;
    uint32_t left = 0;   // a node; in a leaf: its index in BinaryBvh::order
    uint32_t right = 0;  // a node; 0: this is a leaf, with one primitive
    bool IsLeaf() const { return right == 0; }
};

// Holds a binary tree: node 0 is the root, and children come after their parents.
struct BinaryBvh {
    std::vector<BinaryNode> nodes;  // empty without primitives
    std::vector<uint32_t> order;    // primitives in the order of the leaves from left to right

    // Returns the expected cost of a ray that meets the root, where a node costs 1 and a primitive 1.
    double SahCost() const;
};

struct BvhSettings {
    // If true, splits into halves along the longest axis of the boxes' centers, so that no leaf is deeper
    // than others, at more cost to rays. If false, splits by bins of centers.
    bool isBalanced = false;
    uint32_t maxThreads = 0;  // 0: as many as the machine has cores
};
// Builds a tree over finite boxes. The tree does not depend on the number of threads.
BinaryBvh BuildBinaryBvh(std::span<const Box> boxes, const BvhSettings& settings = {});

}  // namespace raygraph
