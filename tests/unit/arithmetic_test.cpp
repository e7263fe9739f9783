// Arithmetic of binding tables, batches and subresources.
#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <vector>

#include "rhi/blas_build.h"
#include "rhi/shader_binding_table.h"
#include "rhi/subresources.h"
#include "tests/support/error_of.h"

// Tests acceleration-structure builds that share scratch memory.
namespace raygraph::rhi::batch_plan_test {
namespace {

using Batches = std::vector<BatchPlan::Batch>;

TEST(BatchPlan, BuildsFillTheBudgetInOrder) {
    const std::vector<uint64_t> shares{40, 60, 1, 99, 100, 50};
    const BatchPlan plan = PlanBatches(shares, 100);
    EXPECT_EQ(plan.batches, (Batches{{0, 2}, {2, 4}, {4, 5}, {5, 6}}));
    EXPECT_EQ(plan.offsets, (std::vector<uint64_t>{0, 40, 0, 1, 0, 0}));
    EXPECT_EQ(plan.scratchBytes, 100u);
}

TEST(BatchPlan, BuildLargerThanTheBudgetHasABatchOfItsOwn) {
    const std::vector<uint64_t> shares{10, 500, 10, 10};
    const BatchPlan plan = PlanBatches(shares, 100);
    EXPECT_EQ(plan.batches, (Batches{{0, 1}, {1, 2}, {2, 4}}));
    EXPECT_EQ(plan.scratchBytes, 500u);
}

TEST(BatchPlan, BuildsOfABatchNeverOverlapAndEveryBuildIsInOneBatch) {
    std::vector<uint64_t> shares(64);
    std::iota(shares.begin(), shares.end(), 1u);
    for (uint64_t budget : {0u, 1u, 64u, 100u, 1000u, 1000000u}) {
        const BatchPlan plan = PlanBatches(shares, budget);
        ASSERT_EQ(plan.offsets.size(), shares.size());
        size_t next = 0;
        for (const BatchPlan::Batch& batch : plan.batches) {
            ASSERT_EQ(batch.first, next);
            ASSERT_GT(batch.end, batch.first);
            uint64_t end = 0;
            for (size_t i = batch.first; i < batch.end; ++i) {
                EXPECT_GE(plan.offsets[i], end);
                end = plan.offsets[i] + shares[i];
            }
            EXPECT_LE(end, plan.scratchBytes);
            EXPECT_TRUE(end <= budget || batch.end - batch.first == 1);
            next = batch.end;
        }
        EXPECT_EQ(next, shares.size());
    }
}

TEST(BatchPlan, NothingNeedsNothing) {
    const BatchPlan plan = PlanBatches({}, 100);
    EXPECT_TRUE(plan.batches.empty());
    EXPECT_EQ(plan.scratchBytes, 0u);
}

}  // namespace
}  // namespace raygraph::rhi::batch_plan_test

namespace raygraph::rhi::shader_binding_table_test {
namespace {

constexpr TableProperties kLavapipe{
    .handleSize = 32, .handleAlignment = 16, .baseAlignment = 32, .maxStride = 4096};
constexpr TableProperties kNvidia{
    .handleSize = 32, .handleAlignment = 32, .baseAlignment = 64, .maxStride = 4096};

constexpr std::array<uint32_t, 2> kNoData2{0, 0};
constexpr std::array<uint32_t, 4> kNoData4{0, 0, 0, 0};

// The compiler evaluates the arithmetic, which needs no device and no memory.
constexpr TableLayout kPlain =
    LayOutTable(kNvidia, {.rayGen = 0, .miss = kNoData2, .hit = kNoData4, .callable = {}});
static_assert(kPlain.rayGen == TableRegion{.offset = 0, .stride = 32, .size = 32, .recordCount = 1});
static_assert(kPlain.miss == TableRegion{.offset = 64, .stride = 32, .size = 64, .recordCount = 2});
static_assert(kPlain.hit == TableRegion{.offset = 128, .stride = 32, .size = 128, .recordCount = 4});
static_assert(kPlain.callable == TableRegion{});
static_assert(kPlain.size == 256);

void ExpectValid(const TableProperties& properties, const TableLayout& layout) {
    uint64_t end = 0;
    for (const TableRegion& region : {layout.rayGen, layout.miss, layout.hit, layout.callable}) {
        EXPECT_EQ(region.size, region.stride * region.recordCount);
        if (region.recordCount == 0) continue;
        EXPECT_EQ(region.offset % properties.baseAlignment, 0u);
        EXPECT_EQ(region.stride % properties.handleAlignment, 0u);
        EXPECT_GE(region.stride, properties.handleSize);
        EXPECT_LE(region.stride, properties.maxStride);
        EXPECT_GE(region.offset, end) << "regions overlap";
        end = region.offset + region.size;
    }
    EXPECT_EQ(layout.rayGen.size, layout.rayGen.stride);
    EXPECT_EQ(layout.size, end);
}

TEST(ShaderBindingTable, PlainRecordsPackAtHandleAlignment) {
    const TableLayout layout =
        LayOutTable(kLavapipe, {.rayGen = 0, .miss = kNoData2, .hit = kNoData4, .callable = kNoData2});
    EXPECT_EQ(layout.rayGen.offset, 0u);
    EXPECT_EQ(layout.miss.offset, 32u);
    EXPECT_EQ(layout.hit.offset, 96u);
    EXPECT_EQ(layout.callable.offset, 224u);
    EXPECT_EQ(layout.size, 288u);
    ExpectValid(kLavapipe, layout);
}

TEST(ShaderBindingTable, StrideHoldsTheLargestRecordOfItsRegionAlone) {
    const std::vector<uint32_t> miss{0, 4};
    const std::vector<uint32_t> hit{0, 20, 8, 0};
    const TableRecords records{.rayGen = 16, .miss = miss, .hit = hit, .callable = {}};

    const TableLayout lavapipe = LayOutTable(kLavapipe, records);
    EXPECT_EQ(lavapipe.rayGen.stride, 48u);  // 32 + 16
    EXPECT_EQ(lavapipe.miss.stride, 48u);    // 32 + 4, up to 16
    EXPECT_EQ(lavapipe.hit.stride, 64u);     // 32 + 20, up to 16
    EXPECT_EQ(lavapipe.miss.offset, 64u);
    EXPECT_EQ(lavapipe.hit.offset, 160u);
    ExpectValid(kLavapipe, lavapipe);

    const TableLayout nvidia = LayOutTable(kNvidia, records);
    EXPECT_EQ(nvidia.rayGen.stride, 64u);
    EXPECT_EQ(nvidia.miss.stride, 64u);
    EXPECT_EQ(nvidia.hit.stride, 64u);
    ExpectValid(kNvidia, nvidia);
}

TEST(ShaderBindingTable, RecordOffsetsFollowTheStride) {
    const std::vector<uint32_t> hit{0, 36, 0};
    const TableLayout layout = LayOutTable(kNvidia, {.rayGen = 0, .miss = {}, .hit = hit, .callable = {}});
    EXPECT_EQ(layout.hit.stride, 96u);
    EXPECT_EQ(layout.hit.RecordOffset(0), layout.hit.offset);
    EXPECT_EQ(layout.hit.RecordOffset(2), layout.hit.offset + 192);
}

TEST(ShaderBindingTable, EmptyRegionsAreZeroAndTakeNoSpace) {
    const TableLayout layout = LayOutTable(kNvidia, {});
    EXPECT_EQ(layout.miss, TableRegion{});
    EXPECT_EQ(layout.hit, TableRegion{});
    EXPECT_EQ(layout.callable, TableRegion{});
    EXPECT_EQ(layout.size, 32u);
}

TEST(ShaderBindingTable, EveryMixOfSizesIsValidOnBothKindsOfDevice) {
    for (uint32_t data = 0; data <= 256; data += 4) {
        const std::vector<uint32_t> sizes{data, 0, data / 2, 4};
        const TableRecords records{.rayGen = data, .miss = sizes, .hit = sizes, .callable = sizes};
        ExpectValid(kLavapipe, LayOutTable(kLavapipe, records));
        ExpectValid(kNvidia, LayOutTable(kNvidia, records));
    }
}

TEST(ShaderBindingTable, RecordLongerThanTheDevicesStrideIsRefused) {
    const std::vector<uint32_t> fits{4096 - 32};
    EXPECT_EQ(LayOutTable(kNvidia, {.rayGen = 0, .miss = {}, .hit = fits, .callable = {}}).hit.stride, 4096u);
    const std::vector<uint32_t> tooLong{4096 - 31};
    const std::string text = testing::ErrorTextOf(
        [&] { LayOutTable(kNvidia, {.rayGen = 0, .miss = {}, .hit = tooLong, .callable = {}}); });
    EXPECT_NE(text.find("4128 bytes exceeds maxShaderGroupStride 4096"), std::string::npos) << text;
}

}  // namespace
}  // namespace raygraph::rhi::shader_binding_table_test

// Tests parts of textures: what they resolve to, what is missing, how they are written.
namespace raygraph::rhi::subresources_test {
namespace {

TEST(Subresources, Default_IsAllOfTheTexture) {
    EXPECT_EQ(Resolved({}, 5, 6), (Subresources{.level = 0, .levelCount = 5, .layer = 0, .layerCount = 6}));
    EXPECT_EQ(PartText(Resolved({}, 5, 6), 5, 6), "");
}

TEST(Subresources, LevelsAreThoseOfAllLayers_LayersThoseOfAllLevels) {
    EXPECT_EQ(Resolved(Level(2), 5, 6),
              (Subresources{.level = 2, .levelCount = 1, .layer = 0, .layerCount = 6}));
    EXPECT_EQ(Resolved(Layers(1, 3), 5, 6),
              (Subresources{.level = 0, .levelCount = 5, .layer = 1, .layerCount = 3}));
    EXPECT_EQ(Resolved({.level = 3}, 5, 6).levelCount, 2u) << "the rest from the third on";
}

TEST(Subresources, Text_NamesWhatIsNotAll) {
    const auto text = [](const Subresources& part) { return PartText(Resolved(part, 5, 6), 5, 6); };
    EXPECT_EQ(text(Level(2)), " level 2");
    EXPECT_EQ(text(Levels(1, 3)), " levels 1-3");
    EXPECT_EQ(text(Layers(2, 2)), " layers 2-3");
    EXPECT_EQ(text(Subresource(4, 1)), " level 4 layer 1");
    EXPECT_EQ(PartText(Resolved(Level(0), 1, 1), 1, 1), "") << "there is no other";
}

TEST(Subresources, WhatIsNotThere_IsNamedWithWhatIs) {
    const auto missing = [](const Subresources& part) { return DescribeMissing(Resolved(part, 5, 1), 5, 1); };
    EXPECT_EQ(missing(Level(4)), "");
    EXPECT_EQ(missing({}), "");
    EXPECT_EQ(missing(Level(5)), "level 5, there are 5");
    EXPECT_EQ(missing({.level = 7}), "level 7, there are 5");
    EXPECT_EQ(missing(Levels(3, 3)), "levels 3-5, there are 5");
    EXPECT_EQ(missing(Levels(1, ~0u - 1)).substr(0, 9), "levels 1-") << "no overflow";
    EXPECT_EQ(missing(Layer(1)), "layer 1, there is 1");
    EXPECT_EQ(missing(Levels(0, 0)), "no level");
}

TEST(Subresources, PartsOverlap_WhereTheyShareALevelOfALayer) {
    const auto overlap = [](const Subresources& a, const Subresources& b) {
        const bool found = Overlap(Resolved(a, 5, 6), Resolved(b, 5, 6));
        EXPECT_EQ(found, Overlap(Resolved(b, 5, 6), Resolved(a, 5, 6)));
        return found;
    };
    EXPECT_TRUE(overlap({}, Subresource(4, 5)));
    EXPECT_TRUE(overlap(Level(2), Layer(3)));
    EXPECT_FALSE(overlap(Level(2), Levels(3, 2)));
    EXPECT_FALSE(overlap(Layers(0, 3), Layer(3)));
    EXPECT_FALSE(overlap(Subresource(1, 1), Subresource(1, 2)));
}

}  // namespace
}  // namespace raygraph::rhi::subresources_test
