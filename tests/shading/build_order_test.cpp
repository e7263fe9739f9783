// Orders of primitives for builders that keep them.
#include "renderer/bvh/build_order.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/triangle_soup.h"

namespace raygraph {
namespace {

// The cost of the tree that joins neighbors, then pairs of them, and so on.
double CostOfPairs(std::span<const Box> boxes, const std::vector<uint32_t>& order) {
    std::vector<Box> level;
    for (const uint32_t i : order) level.push_back(boxes[i]);
    double cost = 0.0;
    while (level.size() > 1) {
        std::vector<Box> above((level.size() + 1) / 2);
        for (size_t i = 0; i < level.size(); ++i) above[i / 2].Extend(level[i]);
        level = std::move(above);
        for (const Box& box : level) cost += double{box.HalfArea()};
    }
    return cost / double{level[0].HalfArea()};
}

TEST(BuildOrder, HasEachPrimitiveOnce) {
    for (const uint32_t count : {1u, 2u, 3u, 5u, 64u, 1001u}) {
        const std::vector<Box> boxes = TriangleBoxes(testing::TriangleSoup(count, 0.1f, count));
        for (const BuildOrder order : Values<BuildOrder>()) {
            std::vector<uint32_t> found = OrderBoxes(boxes, order);
            std::ranges::sort(found);
            ASSERT_EQ(found.size(), count) << Name(order);
            for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(found[i], i) << Name(order);
        }
    }
}

TEST(BuildOrder, BetterOnesCostLessWherePairsAreJoined) {
    const std::vector<Box> boxes = TriangleBoxes(testing::TriangleSoup(5000, 0.05f, 1));
    const auto cost = [&](BuildOrder order) { return CostOfPairs(boxes, OrderBoxes(boxes, order)); };
    const double morton = cost(BuildOrder::Morton);
    std::vector<uint32_t> asTheyCome(boxes.size());
    std::iota(asTheyCome.begin(), asTheyCome.end(), 0u);
    EXPECT_LT(morton, 0.2 * CostOfPairs(boxes, asTheyCome));
    EXPECT_LT(cost(BuildOrder::Hilbert), morton);
    EXPECT_LT(cost(BuildOrder::Halves), 0.95 * morton);
}

}  // namespace
}  // namespace raygraph
