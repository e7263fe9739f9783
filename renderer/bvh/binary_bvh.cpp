#include "renderer/bvh/binary_bvh.h"

#include <algorithm>
#include <array>
#include <future>
#include <numeric>
#include <thread>

namespace raygraph {
namespace {

constexpr uint32_t kBins = 32;
// A range with fewer primitives is not worth a thread of its own.
constexpr uint32_t kParallelCount = 1u << 14;

class Builder {
  public:
    Builder(std::span<const Box> boxes, bool isBalanced, BinaryBvh& tree)
        : m_boxes(boxes), m_isBalanced(isBalanced), m_tree(tree) {
        m_centers.resize(boxes.size());
        std::ranges::transform(boxes, m_centers.begin(), &Box::Center);
        tree.order.resize(boxes.size());
        std::iota(tree.order.begin(), tree.order.end(), 0u);
        tree.nodes.resize(2 * boxes.size() - 1);
    }

    // Builds the subtree of order[first, last) in nodes[node, node + 2 * (last - first) - 1).
    void Build(uint32_t node, uint32_t first, uint32_t last, uint32_t threads) {
        while (true) {
            BinaryNode& target = m_tree.nodes[node];
            for (uint32_t i = first; i < last; ++i) target.box.Extend(m_boxes[m_tree.order[i]]);
            if (last - first == 1) {
                target.left = first;
                return;
            }
            const uint32_t middle = Split(first, last);
            target.left = node + 1;
            target.right = node + 2 * (middle - first);
            if (threads > 1 && last - first > kParallelCount) {
                // The halves are built in turn if no thread can start.
                std::future<void> other = std::async(std::launch::async | std::launch::deferred,
                                                     [this, left = target.left, first, middle, threads] {
                                                         Build(left, first, middle, threads / 2);
                                                     });
                Build(target.right, middle, last, threads - threads / 2);
                other.get();
                return;
            }
            // The smaller part is built by recursion, so that its depth stays small
            const bool isLeftSmaller = middle - first < last - middle;
            if (isLeftSmaller) {
                Build(target.left, first, middle, 1);
                node = target.right;
                first = middle;
            } else {
                Build(target.right, middle, last, 1);
                node = target.left;
                last = middle;
            }
        }
    }

  private:
    struct Bin {
        Box box;
        uint32_t count = 0;
    };

    // Reorders the range; returns the index of the first primitive of the right part.
    uint32_t Split(uint32_t first, uint32_t last) {
        const auto begin = m_tree.order.begin();
        Box centers;
        for (uint32_t i = first; i < last; ++i) centers.Extend(m_centers[m_tree.order[i]]);
        const glm::vec3 size = centers.max - centers.min;
        if (m_isBalanced) return Halve(first, last, size);
        const uint32_t binCount = std::min(kBins, 4 + (last - first) / 2);
        float best = std::numeric_limits<float>::infinity();
        int bestAxis = -1;
        uint32_t bestBin = 0;
        const auto binOf = [&](uint32_t primitive, int axis) {
            const float share = (m_centers[primitive][axis] - centers.min[axis]) / size[axis];
            return std::min(static_cast<uint32_t>(share * static_cast<float>(binCount)), binCount - 1);
        };
        for (int axis = 0; axis < 3; ++axis) {
            if (!(size[axis] > 0.0f)) continue;
            std::array<Bin, kBins> bins{};
            for (uint32_t i = first; i < last; ++i) {
                Bin& bin = bins[binOf(m_tree.order[i], axis)];
                bin.box.Extend(m_boxes[m_tree.order[i]]);
                ++bin.count;
            }
            std::array<float, kBins> rightCosts{};
            Box box;
            uint32_t count = 0;
            for (uint32_t b = binCount - 1; b > 0; --b) {
                box.Extend(bins[b].box);
                count += bins[b].count;
                rightCosts[b] = box.HalfArea() * static_cast<float>(count);
            }
            box = {};
            count = 0;
            for (uint32_t b = 0; b + 1 < binCount; ++b) {
                box.Extend(bins[b].box);
                count += bins[b].count;
                const float cost = box.HalfArea() * static_cast<float>(count) + rightCosts[b + 1];
                if (count == 0 || count == last - first || !(cost < best)) continue;
                best = cost;
                bestAxis = axis;
                bestBin = b;
            }
        }
        if (bestAxis < 0) return first + (last - first) / 2;  // all centers are equal
        const auto middle = std::partition(begin + first, begin + last, [&](uint32_t primitive) {
            return binOf(primitive, bestAxis) <= bestBin;
        });
        return static_cast<uint32_t>(middle - begin);
    }

    uint32_t Halve(uint32_t first, uint32_t last, const glm::vec3& size) {
        const int axis = size.x > size.y && size.x > size.z ? 0 : (size.y > size.z ? 1 : 2);
        const uint32_t middle = first + (last - first) / 2;
        const auto begin = m_tree.order.begin();
        std::nth_element(begin + first, begin + middle, begin + last, [&](uint32_t a, uint32_t b) {
            const float x = m_centers[a][axis], y = m_centers[b][axis];
            return x != y ? x < y : a < b;
        });
        return middle;
    }

    std::span<const Box> m_boxes;
    bool m_isBalanced;
    std::vector<glm::vec3> m_centers;
    BinaryBvh& m_tree;
};

}  // namespace

double BinaryBvh::SahCost() const {
    double cost = 0.0;
    for (const BinaryNode& node : nodes) cost += double{node.box.HalfArea()};
    return nodes.empty() ? 0.0 : cost / double{std::max(nodes[0].box.HalfArea(), 1e-30f)};
}

BinaryBvh BuildBinaryBvh(std::span<const Box> boxes, const BvhSettings& settings) {
    BinaryBvh tree;
    if (boxes.empty()) return tree;
    const uint32_t threads =
        settings.maxThreads != 0 ? settings.maxThreads : std::max(std::thread::hardware_concurrency(), 1u);
    Builder(boxes, settings.isBalanced, tree).Build(0, 0, static_cast<uint32_t>(boxes.size()), threads);
    return tree;
}

}  // namespace raygraph
