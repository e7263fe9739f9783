#include "renderer/bvh/wide_refit.h"

#include <algorithm>
#include <array>
#include <bit>

#include "renderer/bvh/wide_bvh.h"

namespace raygraph {
namespace {

using gpu::kWideChildren;

// Calls `inner` with each slot that is a node and the number of that node, and `leaf` with the slots of
// leaves, each leaf's first primitive, and how many it has.
template <typename Inner, typename Leaf>
void ForEachChild(const gpu::WideNode& node, Inner&& inner, Leaf&& leaf) {
    uint32_t next = node.firstChild;
    for (uint32_t slot = 0; slot < kWideChildren; ++slot) {
        const uint32_t meta = WideMeta(node, slot);
        if (meta == 0u) continue;
        if (IsWideNode(node, slot))
            inner(slot, next++);
        else
            leaf(slot, node.firstPrimitive + (meta & 0x1Fu), static_cast<uint32_t>(std::popcount(meta >> 5)));
    }
}

}  // namespace

WideRefit::WideRefit(std::span<const gpu::WideNode> nodes, const BoxOf& boxOf) : m_nodes(nodes.size()) {
    // Children come after their parents
    for (uint32_t i = static_cast<uint32_t>(nodes.size()); i-- > 0;) {
        Node& node = m_nodes[i];
        ForEachChild(
            nodes[i],
            [&](uint32_t, uint32_t child) {
                m_nodes[child].parent = i;
                node.box.Extend(m_nodes[child].box);
            },
            [&](uint32_t, uint32_t first, uint32_t count) {
                m_nodeOf.resize(std::max<size_t>(m_nodeOf.size(), first + count));
                for (uint32_t p = first; p < first + count; ++p) {
                    m_nodeOf[p] = i;
                    node.box.Extend(boxOf(p));
                }
            });
        node.cost = CostOf(nodes[i], node.box);
        m_cost += node.cost;
    }
    m_costMade = m_cost;
}

void WideRefit::Store(std::span<gpu::WideNode> nodes, uint32_t index, const BoxOf& boxOf) {
    Node& node = m_nodes[index];
    std::array<Box, kWideChildren> children;
    ForEachChild(
        nodes[index], [&](uint32_t slot, uint32_t child) { children[slot] = m_nodes[child].box; },
        [&](uint32_t slot, uint32_t first, uint32_t count) {
            for (uint32_t p = first; p < first + count; ++p) children[slot].Extend(boxOf(p));
        });
    node.box = {};
    for (const Box& child : children) node.box.Extend(child);
    StoreBoxes(nodes[index], node.box, children);
    m_cost -= node.cost;
    node.cost = CostOf(nodes[index], node.box);
    m_cost += node.cost;
}

std::vector<uint32_t> WideRefit::Refit(std::span<gpu::WideNode> nodes, std::span<const uint32_t> moved,
                                       const BoxOf& boxOf) {
    std::vector<uint32_t> dirty;
    for (const uint32_t primitive : moved)
        for (uint32_t i = m_nodeOf[primitive]; !m_nodes[i].isDirty; i = m_nodes[i].parent) {
            m_nodes[i].isDirty = true;
            dirty.push_back(i);
        }
    std::ranges::sort(dirty, std::ranges::greater());
    for (const uint32_t i : dirty) {
        Store(nodes, i, boxOf);
        m_nodes[i].isDirty = false;
    }
    return dirty;
}

double WideRefit::Decay() const {
    return m_costMade > 0.0 ? m_cost / m_costMade : 1.0;
}

}  // namespace raygraph
