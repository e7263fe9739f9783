// The order in which builders get triangles and instances.
#include "renderer/gpu_scene/geometry/spatial_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

namespace raygraph::testing::spatial_order_test {
namespace {

using glm::vec3;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

void ExpectEachOnce(std::vector<uint32_t> order, size_t count) {
    std::ranges::sort(order);
    ASSERT_EQ(order.size(), count);
    for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(order[i], i);
}

std::vector<vec3> ShuffledGrid(uint32_t side) {
    std::vector<vec3> places;
    for (uint32_t i = 0; i < side * side * side; ++i)
        places.emplace_back(float(i % side), float(i / side % side), float(i / side / side));
    std::ranges::shuffle(places, std::mt19937(1));
    return places;
}

// What tells the curve from others: each cell is beside the one before, on every level of the grid.
TEST(SpatialOrder, GoesFromCellToNeighbor) {
    for (const uint32_t side : {2u, 8u, 32u}) {
        const std::vector<vec3> places = ShuffledGrid(side);
        const std::vector<uint32_t> order = SpatialOrder(places);
        ExpectEachOnce(order, places.size());
        for (size_t i = 1; i < order.size(); ++i)
            ASSERT_EQ(glm::distance(places[order[i]], places[order[i - 1]]), 1.0f) << side << ": " << i;
    }
}

// Steps of 2^-21 of the extent on all axes: cells that a coarser curve would take for one.
TEST(SpatialOrder, TellsTheFinestStepsApart) {
    constexpr float kFarAway = (1u << 21) - 1;
    std::vector<vec3> places = ShuffledGrid(8);
    places.emplace_back(kFarAway);
    const std::vector<uint32_t> order = SpatialOrder(places);
    ExpectEachOnce(order, places.size());
    EXPECT_EQ(order.back(), 512u);
    for (size_t i = 1; i + 1 < order.size(); ++i)
        ASSERT_EQ(glm::distance(places[order[i]], places[order[i - 1]]), 1.0f) << i;
}

TEST(SpatialOrder, OneThatIsFarAwayLeavesTheOrderOfTheOthers) {
    std::vector<vec3> places;
    for (uint32_t i = 0; i < 1000; ++i)
        places.emplace_back(float(i * 37 % 10), float(i * 37 / 10 % 10), float(i * 37 / 100 % 10));
    places.emplace_back(1e5f, -1e5f, 3e5f);
    const std::vector<uint32_t> order = SpatialOrder(places);
    ExpectEachOnce(order, places.size());
    double way = 0.0;
    for (size_t i = 1; i < order.size(); ++i)
        if (order[i] != 1000 && order[i - 1] != 1000)
            way += glm::distance(places[order[i]], places[order[i - 1]]);
    EXPECT_LT(way / 1000.0, 1.5) << "from each to the next";
}

TEST(SpatialOrder, DegenerateBoundsKeepWhatTheyTell) {
    EXPECT_TRUE(SpatialOrder({}).empty());
    EXPECT_EQ(SpatialOrder(std::vector<vec3>{{3, 4, 5}}), std::vector<uint32_t>{0});
    // All at one place, and at the ends of the range of floats: as they came
    for (const vec3 place : {vec3(0.0f), vec3(-7.0f, 1e-38f, 3e38f)})
        EXPECT_EQ(SpatialOrder(std::vector<vec3>(3, place)), (std::vector<uint32_t>{0, 1, 2}));
    // On a line, near which the curve passes in parts
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<vec3> line(128, vec3(-2.0f));
        for (uint32_t i = 0; i < line.size(); ++i) line[i][axis] = float(i * 37 % 128);
        const std::vector<uint32_t> order = SpatialOrder(line);
        ExpectEachOnce(order, line.size());
        float way = 0.0f;
        for (size_t i = 1; i < order.size(); ++i) way += glm::distance(line[order[i]], line[order[i - 1]]);
        EXPECT_LT(way, 4.0f * 128.0f) << axis;
    }
}

TEST(SpatialOrder, WhatIsNotFiniteIsAmongTheNearestAndBoundsNothing) {
    std::vector<vec3> places{{kNan, kNan, kNan}, {kInfinity, kInfinity, kInfinity}, {-kInfinity, kNan, 0}};
    const std::vector<vec3> grid = ShuffledGrid(4);
    places.insert(places.end(), grid.begin(), grid.end());
    std::vector<uint32_t> order = SpatialOrder(places);
    ExpectEachOnce(order, places.size());
    for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(order[i], i) << "beside the lowest, as they came";
    EXPECT_EQ(places[order[3]], vec3(0.0f));
    for (size_t i = 4; i < order.size(); ++i)
        ASSERT_EQ(glm::distance(places[order[i]], places[order[i - 1]]), 1.0f);
}

TEST(SpatialOrder, TrianglesFollowTheirCenters) {
    const std::vector<vec3> places = ShuffledGrid(4);
    std::vector<vec3> positions;
    std::vector<uint32_t> indices(3 * places.size());
    for (const vec3& place : places)
        for (const vec3& corner : {vec3(0), vec3(0.3f, 0, 0), vec3(0, 0.3f, 0)})
            positions.push_back(place + corner);
    std::iota(indices.begin(), indices.end(), 0u);
    const std::vector<uint32_t> originals = SortTriangles(positions, indices);
    ExpectEachOnce(originals, places.size());
    for (uint32_t i = 0; i < originals.size(); ++i) {
        for (uint32_t corner = 0; corner < 3; ++corner)
            ASSERT_EQ(indices[3 * i + corner], 3 * originals[i] + corner);
        if (i > 0) {
            ASSERT_EQ(glm::distance(places[originals[i]], places[originals[i - 1]]), 1.0f) << i;
        }
    }
    EXPECT_TRUE(SortTriangles(positions, indices).empty()) << "nothing to do";
}

}  // namespace
}  // namespace raygraph::testing::spatial_order_test
