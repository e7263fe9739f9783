#include "renderer/bvh/build_order.h"

#include <meshoptimizer.h>

#include <bit>
#include <numeric>
#include <thread>

#include "renderer/bvh/binary_bvh.h"
#include "renderer/gpu_scene/spatial_order.h"

namespace raygraph {
namespace {

std::vector<glm::vec3> Centers(std::span<const Box> boxes) {
    std::vector<glm::vec3> centers(boxes.size());
    std::ranges::transform(boxes, centers.begin(), &Box::Center);
    return centers;
}

std::vector<uint32_t> MortonOrder(std::span<const Box> boxes) {
    const std::vector<glm::vec3> centers = Centers(boxes);
    std::vector<uint32_t> places(boxes.size()), order(boxes.size());
    if (boxes.empty()) return order;
    meshopt_spatialSortRemap(places.data(), &centers[0].x, centers.size(), sizeof(glm::vec3));
    for (uint32_t i = 0; i < places.size(); ++i) order[places[i]] = i;
    return order;
}

// Top down: of the axes, and of their two directions, the one whose halves cost the least.
class Halving {
  public:
    explicit Halving(std::span<const Box> boxes)
        : m_boxes(boxes), m_centers(Centers(boxes)), m_order(boxes.size()) {
        std::iota(m_order.begin(), m_order.end(), 0u);
        Split(0, static_cast<uint32_t>(boxes.size()), std::max(std::thread::hardware_concurrency(), 1u));
    }
    std::vector<uint32_t> Take() { return std::move(m_order); }

  private:
    void Split(uint32_t first, uint32_t last, uint32_t threads) {
        const uint32_t count = last - first;
        if (count <= 2) return;
        const uint32_t left = std::bit_ceil(count) / 2;
        float least = std::numeric_limits<float>::infinity();
        int best = 0;
        // The last one tried stays
        for (int choice = 0; choice <= 6; ++choice) {
            const int tried = choice < 6 ? choice : best;
            if (choice == 6 && best == 5) break;
            const int axis = tried / 2;
            const bool isDown = tried % 2 != 0;
            const auto begin = m_order.begin() + first;
            std::nth_element(begin, begin + left, begin + count, [&](uint32_t a, uint32_t b) {
                const float x = m_centers[a][axis], y = m_centers[b][axis];
                if (x != y) return isDown ? x > y : x < y;
                return a < b;
            });
            if (choice == 6) break;
            const float cost = Bound(first, first + left).HalfArea() * static_cast<float>(left) +
                               Bound(first + left, last).HalfArea() * static_cast<float>(count - left);
            if (!(cost < least)) continue;
            least = cost;
            best = choice;
        }
        if (threads > 1) {
            const std::jthread other([=, this] { Split(first, first + left, threads / 2); });
            Split(first + left, last, threads - threads / 2);
            return;
        }
        Split(first, first + left, 1);
        Split(first + left, last, 1);
    }
    Box Bound(uint32_t first, uint32_t last) const {
        Box box;
        for (uint32_t i = first; i < last; ++i) box.Extend(m_boxes[m_order[i]]);
        return box;
    }

    std::span<const Box> m_boxes;
    std::vector<glm::vec3> m_centers;
    std::vector<uint32_t> m_order;
};

}  // namespace

std::vector<uint32_t> OrderBoxes(std::span<const Box> boxes, BuildOrder order) {
    switch (order) {
        case BuildOrder::Hilbert:
            break;
        case BuildOrder::Morton:
            return MortonOrder(boxes);
        case BuildOrder::Tree:
            return BuildBinaryBvh(boxes).order;
        case BuildOrder::Halves:
            return boxes.empty() ? std::vector<uint32_t>() : Halving(boxes).Take();
    }
    return SpatialOrder(Centers(boxes));
}

}  // namespace raygraph
