#include "renderer/bvh/build_order.h"

#include <array>
#include <bit>
#include <numeric>
#include <thread>

#include "renderer/bvh/binary_bvh.h"
#include "renderer/gpu_scene/spatial_order.h"

namespace raygraph {
namespace {

constexpr uint32_t kHilbertBits = 21;

std::vector<glm::vec3> Centers(std::span<const Box> boxes) {
    std::vector<glm::vec3> centers(boxes.size());
    std::ranges::transform(boxes, centers.begin(), &Box::Center);
    return centers;
}

// The place along the curve: Skilling 2004, "Programming the Hilbert curve".
uint64_t HilbertPlace(std::array<uint32_t, 3> x) {
    for (uint32_t q = 1u << (kHilbertBits - 1); q > 1; q >>= 1) {
        const uint32_t p = q - 1;
        for (uint32_t& its : x) {
            if ((its & q) != 0u) {
                x[0] ^= p;
            } else {
                const uint32_t t = (x[0] ^ its) & p;
                x[0] ^= t;
                its ^= t;
            }
        }
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    uint32_t t = 0;
    for (uint32_t q = 1u << (kHilbertBits - 1); q > 1; q >>= 1)
        if ((x[2] & q) != 0u) t ^= q - 1;
    uint64_t place = 0;
    for (uint32_t bit = kHilbertBits; bit-- > 0;)
        for (const uint32_t its : x) place = place << 1 | ((its ^ t) >> bit & 1u);
    return place;
}

std::vector<uint32_t> HilbertOrder(std::span<const Box> boxes) {
    const std::vector<glm::vec3> centers = Centers(boxes);
    Box all;
    for (const glm::vec3& center : centers) all.Extend(center);
    const glm::dvec3 size(all.max - all.min);
    const double scale = ((1u << kHilbertBits) - 1) / std::max({size.x, size.y, size.z, 1e-30});
    std::vector<std::pair<uint64_t, uint32_t>> keyed(boxes.size());
    for (uint32_t i = 0; i < keyed.size(); ++i) {
        const glm::uvec3 step((glm::dvec3(centers[i]) - glm::dvec3(all.min)) * scale);
        keyed[i] = {HilbertPlace({step.x, step.y, step.z}), i};
    }
    std::ranges::sort(keyed);
    std::vector<uint32_t> order(boxes.size());
    std::ranges::transform(keyed, order.begin(), [](const auto& key) { return key.second; });
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
        case BuildOrder::Morton:
            break;
        case BuildOrder::Hilbert:
            return HilbertOrder(boxes);
        case BuildOrder::Tree:
            return BuildBinaryBvh(boxes).order;
        case BuildOrder::Halves:
            return boxes.empty() ? std::vector<uint32_t>() : Halving(boxes).Take();
    }
    return SpatialOrder(Centers(boxes));
}

}  // namespace raygraph
