// Masks and layouts of every access against the table written from the specification.
#include "renderer/graph/access.h"

#include <gtest/gtest.h>

#include "renderer/graph/frame_graph.h"
#include "tests/graph/access_table.h"

namespace raygraph::access_test {
namespace {

using golden::AccessRow;
using golden::Effect;

constexpr std::array kKinds{PassKind::RayTracing, PassKind::Compute, PassKind::Raster, PassKind::Transfer,
                            PassKind::AccelerationStructure};
constexpr uint32_t kAccessCount = static_cast<uint32_t>(Access::Count);

std::string Text(PassKind kind, Access access) {
    return std::string(Name(kind)) + ", " + Name(access);
}

TEST(AccessTable, EveryPairIsThereOrRefused) {
    size_t legal = 0;
    for (const PassKind kind : kKinds)
        for (uint32_t a = 0; a < kAccessCount; ++a) {
            const auto access = static_cast<Access>(a);
            EXPECT_EQ(IsLegal(kind, access), golden::Find(kind, access) != nullptr) << Text(kind, access);
            legal += IsLegal(kind, access) ? 1 : 0;
        }
    EXPECT_EQ(legal, golden::kAccessRows.size()) << "a row comes twice";
}

TEST(AccessTable, StagesAccessesAndLayoutsAreTheSpecifications) {
    for (const AccessRow& row : golden::kAccessRows) {
        const AccessMasks masks = MasksFor(row.kind, row.access);
        EXPECT_EQ(masks.stages, row.stages) << Text(row.kind, row.access);
        EXPECT_EQ(masks.access, row.accesses) << Text(row.kind, row.access);
        EXPECT_EQ(masks.layout, row.layout) << Text(row.kind, row.access);
    }
}

TEST(AccessTable, EffectsOnContents) {
    for (const AccessRow& row : golden::kAccessRows) {
        EXPECT_EQ(Writes(row.access), row.effect != Effect::Reads) << Text(row.kind, row.access);
        EXPECT_EQ(NeedsContents(row.access), row.effect != Effect::Replaces) << Text(row.kind, row.access);
    }
}

}  // namespace
}  // namespace raygraph::access_test
