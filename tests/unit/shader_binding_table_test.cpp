#include "rhi/shader_binding_table.h"
#include "tests/support/error_of.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

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
