// Tests acceleration-structure builds that share scratch memory.
#include <gtest/gtest.h>

#include <numeric>

#include "rhi/blas_build.h"

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
