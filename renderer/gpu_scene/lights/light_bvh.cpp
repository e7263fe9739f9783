#include "renderer/gpu_scene/lights/light_bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <functional>
#include <limits>

#include "base/check.h"

namespace raygraph {

namespace {

constexpr uint32_t kMaxDepth = 32;  // bits of a trail
constexpr uint32_t kBucketCount = 12;

}  // namespace

class LightTree::Builder {
  public:
    Builder(LightTree& tree, std::span<gpu::LightRecord> lights) : m_tree(tree), m_lights(lights) {}

    LightBounds BuildNode(uint32_t node, std::span<LightLeaf> items, uint32_t depth, uint32_t trail) {
        if (items.size() == 1) {
            m_lights[items[0].light].bitTrail = trail;
            m_tree.m_leafOf[items[0].light] = node;
            m_tree.Write(node, items[0].bounds, gpu::kLightNodeLeaf | items[0].light);
            return items[0].bounds;
        }
        RG_CHECK_LT(depth, kMaxDepth);
        const size_t middle = Split(items, depth);
        const uint32_t first = m_count;
        m_count += 2;
        m_tree.m_rest[first].parent = m_tree.m_rest[first + 1].parent = node;
        LightBounds bounds = BuildNode(first, items.first(middle), depth + 1, trail);
        Unite(bounds, BuildNode(first + 1, items.subspan(middle), depth + 1, trail | (1u << depth)));
        m_tree.Write(node, bounds, first);
        return bounds;
    }

  private:
    // Partitions the items into two non-empty parts; returns the size of the first.
    static size_t Split(std::span<LightLeaf> items, uint32_t depth) {
        if (items.size() == 2) return 1;
        glm::vec3 low(std::numeric_limits<float>::infinity()), high = -low;
        for (const LightLeaf& item : items) {
            low = glm::min(low, item.center);
            high = glm::max(high, item.center);
        }
        const glm::vec3 extent = high - low;
        const int longest = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        // Halving reaches the leaves within the remaining depth; another split may not
        const bool mustHalve = depth + std::bit_width(items.size() - 1) >= kMaxDepth;
        if (!mustHalve && extent[longest] > 0.0f) {
            const size_t middle = SplitByCost(items, low, extent);
            if (middle > 0 && middle < items.size()) return middle;
        }
        const size_t middle = items.size() / 2;
        std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(middle), items.end(),
                         [longest](const LightLeaf& a, const LightLeaf& b) {
                             return a.center[longest] < b.center[longest];
                         });
        return middle;
    }

    static uint32_t BucketOf(const LightLeaf& item, int axis, const glm::vec3& low, const glm::vec3& extent) {
        const float place = (item.center[axis] - low[axis]) / extent[axis] * float{kBucketCount};
        // A NaN, for an extent beyond the range of floats, goes to bucket 0
        return std::min(static_cast<uint32_t>(std::max(0.0f, place)), kBucketCount - 1);
    }

    static size_t SplitByCost(std::span<LightLeaf> items, const glm::vec3& low, const glm::vec3& extent) {
        const float longest = std::max({extent.x, extent.y, extent.z});
        double bestCost = std::numeric_limits<double>::infinity();
        int bestAxis = 0;
        uint32_t bestBucket = 0;  // index of the first bucket of the second part
        for (int axis = 0; axis < 3; ++axis) {
            if (!(extent[axis] > 0.0f)) continue;
            std::array<LightBounds, kBucketCount> buckets;
            for (const LightLeaf& item : items)
                Unite(buckets[BucketOf(item, axis, low, extent)], item.bounds);
            std::array<double, kBucketCount> costBelow{};
            LightBounds below, above;
            for (uint32_t b = 1; b < kBucketCount; ++b) {
                Unite(below, buckets[b - 1]);
                costBelow[b] = Cost(below);
            }
            for (uint32_t b = kBucketCount - 1; b > 0; --b) {
                Unite(above, buckets[b]);
                const double cost = (costBelow[b] + Cost(above)) * longest / extent[axis];
                if (!above.IsEmpty() && cost < bestCost) {
                    bestCost = cost;
                    bestAxis = axis;
                    bestBucket = b;
                }
            }
        }
        const auto middle = std::partition(items.begin(), items.end(), [&](const LightLeaf& item) {
            return BucketOf(item, bestAxis, low, extent) < bestBucket;
        });
        return static_cast<size_t>(middle - items.begin());
    }

    LightTree& m_tree;
    std::span<gpu::LightRecord> m_lights;
    uint32_t m_count = 1;  // number of nodes
};

void LightTree::Build(std::vector<LightLeaf> leaves, std::span<gpu::LightRecord> lights) {
    for (LightLeaf& leaf : leaves) leaf.center = 0.5f * (leaf.bounds.min + leaf.bounds.max);
    m_nodes.clear();
    m_rest.clear();
    m_set.clear();
    m_leafOf.assign(lights.size(), kNoNode);
    if (!leaves.empty()) {
        m_nodes.resize(2 * leaves.size() - 1);
        m_rest.resize(m_nodes.size());
        Builder(*this, lights).BuildNode(0, leaves, 0, 0);
    }
    SumCosts();
}

void LightTree::Write(uint32_t node, const LightBounds& bounds, uint32_t link) {
    m_nodes[node] = NodeOf(bounds, link);
    m_rest[node].thetaO = static_cast<float>(bounds.thetaO);
    m_rest[node].thetaE = static_cast<float>(bounds.thetaE);
}

LightBounds LightTree::BoundsAt(uint32_t node) const {
    const gpu::LightNode& from = m_nodes[node];
    return {.min = from.boundsMin,
            .max = from.boundsMax,
            .axis = glm::dvec3(from.axis),
            .thetaO = m_rest[node].thetaO,
            .thetaE = m_rest[node].thetaE,
            .power = from.power,
            .isTwoSided = (from.link & gpu::kLightNodeTwoSided) != 0u};
}

double LightTree::InnerCost(uint32_t node) const {
    return (m_nodes[node].link & gpu::kLightNodeLeaf) != 0u ? 0.0 : Cost(BoundsAt(node));
}

void LightTree::SumCosts() {
    m_cost = 0.0;
    for (uint32_t node = 0; node < m_nodes.size(); ++node) m_cost += InnerCost(node);
    m_highestCost = m_cost;
}

double LightTree::RelativeCost() const {
    const double root = m_nodes.empty() ? 0.0 : InnerCost(0);
    return root > 0.0 ? m_cost / root : 0.0;
}

void LightTree::Set(uint32_t light, const LightBounds& bounds) {
    const uint32_t leaf = m_leafOf[light];
    const gpu::LightNode old = m_nodes[leaf];
    Write(leaf, bounds, gpu::kLightNodeLeaf | light);
    if (std::memcmp(&old, &m_nodes[leaf], sizeof(old)) != 0) m_set.push_back(leaf);
}

void LightTree::Refit(std::vector<uint32_t>& changed) {
    changed.insert(changed.end(), m_set.begin(), m_set.end());
    std::vector<uint32_t> above;
    for (const uint32_t leaf : m_set)
        for (uint32_t node = m_rest[leaf].parent; node != kNoNode; node = m_rest[node].parent)
            above.push_back(node);
    m_set.clear();
    // Children have larger indices than their parents
    std::ranges::sort(above, std::greater());
    above.erase(std::unique(above.begin(), above.end()), above.end());
    for (const uint32_t node : above) {
        const gpu::LightNode old = m_nodes[node];
        const uint32_t first = old.link & gpu::kLightNodeIndex;
        m_cost -= InnerCost(node);
        LightBounds bounds = BoundsAt(first);
        Unite(bounds, BoundsAt(first + 1));
        Write(node, bounds, first);
        m_cost += InnerCost(node);
        if (std::memcmp(&old, &m_nodes[node], sizeof(old)) != 0) changed.push_back(node);
    }
    m_highestCost = std::max(m_highestCost, m_cost);
    if (!(m_cost > 1e-3 * m_highestCost)) SumCosts();
}

LightTree BuildLightTree(std::span<gpu::LightRecord> lights, std::span<const float> power) {
    RG_CHECK_EQ(lights.size(), power.size());
    std::vector<LightLeaf> leaves;
    for (uint32_t i = 0; i < lights.size(); ++i) {
        lights[i].bitTrail = 0;
        if (power[i] > 0.0f) leaves.push_back({.bounds = BoundsOf(lights[i], power[i]), .light = i});
    }
    LightTree tree;
    tree.Build(std::move(leaves), lights);
    return tree;
}

}  // namespace raygraph
