#include "renderer/bvh/wide_bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/check.h"

namespace raygraph {
namespace {

using gpu::kWideChildren;
using gpu::kWideLeafPrimitives;
using gpu::WideNode;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Boxes are larger than their contents by this margin, relative to their node: more than the rounding of
// where a ray meets their sides (scene/wide_bvh.glsl).
constexpr double kMargin = 1.0 / (1 << 18);

// Returns the least exponent whose 255 steps reach as far.
uint32_t BiasedExponent(double size) {
    RG_CHECK(std::isfinite(size));
    int exponent = size > 0.0 ? static_cast<int>(std::ceil(std::log2(size / 255.0))) : -100;
    while (std::ldexp(255.0, exponent) < size) ++exponent;
    return static_cast<uint32_t>(std::clamp(exponent, -100, 127) + 127);
}

float RoundDown(double x) {
    const float rounded = static_cast<float>(x);
    return double{rounded} > x ? std::nextafter(rounded, -kInfinity) : rounded;
}

// Holds the decision of section 3 of the paper for a binary node: cost[i] is the cost of its subtree as at
// most i + 1 wide children of one node.
struct Choice {
    std::array<float, kWideChildren - 1> cost{};
    // Holds how many of at most i + 1 children come from the left child; 0: the same decision as with one
    // fewer. The last entry is for this node as a wide one.
    std::array<uint8_t, kWideChildren> left{};
    bool isLeaf = false;
};

class Collapse {
  public:
    explicit Collapse(const BinaryBvh& tree)
        : m_tree(tree), m_choices(tree.nodes.size()), m_ranges(tree.nodes.size()) {
        for (size_t i = tree.nodes.size(); i-- > 0;) Choose(static_cast<uint32_t>(i));
    }

    WideBvh Emit() {
        m_wide.nodes.emplace_back();
        if (m_tree.nodes.empty()) return std::move(m_wide);
        m_wide.primitives.reserve(m_tree.order.size());
        struct Pending {
            uint32_t wide, binary, depth;
        };
        std::vector<Pending> stack{{0, 0, 1}};
        while (!stack.empty()) {
            const Pending next = stack.back();
            stack.pop_back();
            m_wide.depth = std::max(m_wide.depth, next.depth);
            const std::vector<uint32_t> inner = EmitNode(next.wide, next.binary);
            const uint32_t first = m_wide.nodes[next.wide].firstChild;
            for (size_t i = inner.size(); i-- > 0;)
                stack.push_back({first + static_cast<uint32_t>(i), inner[i], next.depth + 1});
        }
        m_wide.sahCost = m_cost / double{std::max(m_tree.nodes[0].box.HalfArea(), 1e-30f)};
        return std::move(m_wide);
    }

  private:
    struct Range {
        uint32_t first = 0;  // in order
        uint32_t count = 0;
    };

    void Choose(uint32_t index) {
        const BinaryNode& node = m_tree.nodes[index];
        Choice& choice = m_choices[index];
        const float area = node.box.HalfArea();
        if (node.IsLeaf()) {
            m_ranges[index] = {node.left, 1};
            choice.isLeaf = true;
            choice.cost.fill(area * kWidePrimitiveCost);
            return;
        }
        const Choice &left = m_choices[node.left], &right = m_choices[node.right];
        m_ranges[index] = {m_ranges[node.left].first, m_ranges[node.left].count + m_ranges[node.right].count};
        const uint32_t count = m_ranges[index].count;
        const auto distribute = [&](uint32_t children) {
            float least = kInfinity;  // stays so where areas are beyond a float
            choice.left[children - 1] = 1;
            for (uint32_t k = 1; k < children; ++k) {
                const float cost = left.cost[k - 1] + right.cost[children - k - 1];
                if (!(cost < least)) continue;
                least = cost;
                choice.left[children - 1] = static_cast<uint8_t>(k);
            }
            return least;
        };
        const float asNode = distribute(kWideChildren) + area;
        const float asLeaf =
            count <= kWideLeafPrimitives ? area * static_cast<float>(count) * kWidePrimitiveCost : kInfinity;
        choice.isLeaf = asLeaf <= asNode;
        choice.cost[0] = std::min(asLeaf, asNode);
        for (uint32_t children = 2; children < kWideChildren; ++children) {
            choice.cost[children - 1] = distribute(children);
            if (choice.cost[children - 2] <= choice.cost[children - 1]) {
                choice.cost[children - 1] = choice.cost[children - 2];
                choice.left[children - 1] = 0;
            }
        }
    }

    // Appends the at most `count` wide children that the subtree becomes.
    void Gather(uint32_t index, uint32_t count, std::vector<uint32_t>& children) const {
        const BinaryNode& node = m_tree.nodes[index];
        while (count > 1 && (node.IsLeaf() || m_choices[index].left[count - 1] == 0)) --count;
        if (count == 1) {
            children.push_back(index);
            return;
        }
        GatherBoth(index, count, children);
    }
    void GatherBoth(uint32_t index, uint32_t count, std::vector<uint32_t>& children) const {
        const uint32_t left = m_choices[index].left[count - 1];
        Gather(m_tree.nodes[index].left, left, children);
        Gather(m_tree.nodes[index].right, count - left, children);
    }

    // Returns the slot of each child, such that children lie as far in the directions of their slots' octants
    // as possible: by a table over all sets of slots that the first children may take.
    std::array<uint32_t, kWideChildren> Slots(const Box& box, const std::vector<uint32_t>& children) const {
        constexpr uint32_t kSets = 1u << kWideChildren;
        std::array<float, kSets> best;
        std::array<uint8_t, kSets> last{};
        best.fill(-kInfinity);
        best[0] = 0.0f;
        const glm::vec3 center = box.Center();
        std::array<std::array<float, kWideChildren>, kWideChildren> gains;
        for (size_t i = 0; i < children.size(); ++i) {
            const glm::vec3 d = m_tree.nodes[children[i]].box.Center() - center;
            for (uint32_t slot = 0; slot < kWideChildren; ++slot)
                gains[i][slot] =
                    (slot & 1u ? d.x : -d.x) + (slot & 2u ? d.y : -d.y) + (slot & 4u ? d.z : -d.z);
        }
        // A set without one of its slots is a smaller number
        for (uint32_t set = 1; set < kSets; ++set) {
            const size_t i = static_cast<size_t>(std::popcount(set)) - 1;
            if (i >= children.size()) continue;
            for (uint32_t slots = set; slots != 0; slots &= slots - 1) {
                const auto slot = static_cast<uint32_t>(std::countr_zero(slots));
                const float sum = best[set ^ (1u << slot)] + gains[i][slot];
                if (!(sum > best[set])) continue;
                best[set] = sum;
                last[set] = static_cast<uint8_t>(slot);
            }
        }
        uint32_t set = 0;
        for (uint32_t other = 0; other < kSets; ++other)
            if (static_cast<size_t>(std::popcount(other)) == children.size() &&
                (set == 0 || best[other] > best[set]))
                set = other;
        std::array<uint32_t, kWideChildren> slots{};
        for (size_t i = children.size(); i-- > 0;) {
            slots[i] = last[set];
            set ^= 1u << slots[i];
        }
        return slots;
    }

    // Returns the binary nodes of the children that are nodes, by slot.
    std::vector<uint32_t> EmitNode(uint32_t wideIndex, uint32_t index) {
        std::vector<uint32_t> children;
        if (m_tree.nodes[index].IsLeaf())
            children.push_back(index);
        else
            GatherBoth(index, kWideChildren, children);
        const Box& box = m_tree.nodes[index].box;
        const std::array<uint32_t, kWideChildren> slots = Slots(box, children);
        std::array<int64_t, kWideChildren> bySlot;
        bySlot.fill(-1);
        for (size_t i = 0; i < children.size(); ++i) bySlot[slots[i]] = children[i];

        WideNode node{};
        std::array<Box, kWideChildren> boxes;
        node.firstPrimitive = static_cast<uint32_t>(m_wide.primitives.size());
        std::vector<uint32_t> inner;
        for (uint32_t slot = 0; slot < kWideChildren; ++slot) {
            if (bySlot[slot] < 0) continue;
            const uint32_t child = static_cast<uint32_t>(bySlot[slot]);
            const Range& range = m_ranges[child];
            uint32_t meta = 0;
            if (m_choices[child].isLeaf) {
                meta = ((1u << range.count) - 1u) << 5 |
                       (static_cast<uint32_t>(m_wide.primitives.size()) - node.firstPrimitive);
                for (uint32_t i = 0; i < range.count; ++i)
                    m_wide.primitives.push_back(m_tree.order[range.first + i]);
            } else {
                meta = 1u << 5 | (24 + slot);
                node.exponents |= 1u << (24 + slot);
                inner.push_back(child);
            }
            node.meta[slot / 4] |= meta << (8 * (slot % 4));
            boxes[slot] = m_tree.nodes[child].box;
        }
        StoreBoxes(node, box, boxes);
        m_cost += CostOf(node, box);
        node.firstChild = static_cast<uint32_t>(m_wide.nodes.size());
        m_wide.nodes.resize(m_wide.nodes.size() + inner.size());
        m_wide.nodes[wideIndex] = node;
        return inner;
    }

    const BinaryBvh& m_tree;
    std::vector<Choice> m_choices;
    std::vector<Range> m_ranges;
    WideBvh m_wide;
    double m_cost = 0.0;
};

}  // namespace

Box WideChildBox(const WideNode& node, uint32_t slot) {
    Box box;
    if (WideMeta(node, slot) == 0u) return box;
    for (int axis = 0; axis < 3; ++axis) {
        const float step = std::ldexp(1.0f, static_cast<int>(node.exponents >> (8 * axis) & 0xFFu) - 127);
        const auto at = [&](const uint32_t* words) {
            return node.origin[axis] + step * static_cast<float>(words[slot / 4] >> (8 * (slot % 4)) & 0xFFu);
        };
        box.min[axis] = at(node.low + 2 * axis);
        box.max[axis] = at(node.high + 2 * axis);
    }
    return box;
}

void StoreBoxes(WideNode& node, const Box& box, std::span<const Box, kWideChildren> children) {
    glm::dvec3 margin(0.0);
    node.exponents &= 0xFF000000u;
    for (int axis = 0; axis < 3; ++axis) {
        margin[axis] = kMargin * (double{box.max[axis]} - double{box.min[axis]});
        node.origin[axis] = RoundDown(double{box.min[axis]} - margin[axis]);
        node.exponents |= BiasedExponent(double{box.max[axis]} + margin[axis] - double{node.origin[axis]})
                          << (8 * axis);
        const double step = std::ldexp(1.0, static_cast<int>(node.exponents >> (8 * axis) & 0xFFu) - 127);
        const auto steps = [&](double at) { return (at - double{node.origin[axis]}) / step; };
        uint32_t *const low = node.low + 2 * axis, *const high = node.high + 2 * axis;
        low[0] = low[1] = high[0] = high[1] = 0;
        for (uint32_t slot = 0; slot < kWideChildren; ++slot) {
            if (WideMeta(node, slot) == 0u) continue;
            const auto put = [slot](uint32_t* words, double byte) {
                words[slot / 4] |= static_cast<uint32_t>(byte) << (8 * (slot % 4));
            };
            put(low, std::max(std::floor(steps(double{children[slot].min[axis]} - margin[axis])), 0.0));
            put(high, std::ceil(steps(double{children[slot].max[axis]} + margin[axis])));
        }
    }
}

double CostOf(const WideNode& node, const Box& box) {
    double cost = double{box.HalfArea()};
    for (uint32_t slot = 0; slot < kWideChildren; ++slot) {
        const uint32_t meta = WideMeta(node, slot);
        if (meta == 0u || IsWideNode(node, slot)) continue;
        const auto count = static_cast<float>(std::popcount(meta >> 5));
        cost += double{WideChildBox(node, slot).HalfArea() * count} * double{kWidePrimitiveCost};
    }
    return cost;
}

WideBvh CollapseToWide(const BinaryBvh& tree) {
    return Collapse(tree).Emit();
}

// --- WideRefit ---

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
