// Deforming structures: built anew in place, and compacted.
#include <gtest/gtest.h>

#include "rhi/blas_builder.h"
#include "rhi/device.h"
#include "tests/rhi/trace_test.h"
#include "tests/support/error_of.h"

namespace raygraph::rhi {
namespace {

class BlasRebuild : public TraceTest {
  protected:
    std::vector<TestResult> Hits(const std::shared_ptr<Blas>& blas) {
        return Trace(PlainPipeline(), BuildTlas({Instance(*blas)}), RayGrid(64));
    }
};

TEST_F(BlasRebuild, RebuildInPlaceMovesAHitAndKeepsTheAddress) {
    BlasBuilder builder(Device(), {.name = "deforming"});
    const std::shared_ptr<Blas> blas = builder.Add(Describe(Quad(0, 0), BlasKind::Deforming));
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    const VkDeviceAddress address = blas->Address();
    const std::vector<BlasBuilder::RefitRequest> requests{
        {blas.get(), Describe(Quad(3, -1), BlasKind::Deforming), true}};
    Run([&](CommandList& commands) { builder.RecordRefits(commands, requests); });
    const std::vector<TestRay> rays{{.origin = {0.1f, 0.2f, -4}}, {.origin = {3.1f, 0.2f, -4}}};
    const std::vector<TestResult> results = Trace(PlainPipeline(), BuildTlas({Instance(*blas)}), rays);
    EXPECT_EQ(results[0].code, 2u);
    EXPECT_FLOAT_EQ(results[1].distance, 3.0f);
    EXPECT_EQ(blas->Address(), address);
    EXPECT_EQ(builder.Statistics().rebuildCount, 1u);
    EXPECT_EQ(builder.Statistics().refitCount, 0u);
    {
        CommandList dropped = Device().BeginCommands("dropped");
        builder.RecordRefits(dropped, requests);
    }
    EXPECT_EQ(builder.Statistics().rebuildCount, 1u) << "of submitted lists";
}

// Which no engine does unless it has measured that it pays.
TEST_F(BlasRebuild, CompactedDeformingOnesAreRefittedButNotRebuilt) {
    BlasBuilder builder(Device(), {.name = "small", .compactsWithoutGain = true, .compactsDeforming = true});
    const std::shared_ptr<Blas> blas = builder.Add(Describe(Waves(12), BlasKind::Deforming));
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    ASSERT_TRUE(builder.Poll());
    Run([&](CommandList& commands) { builder.RecordCompaction(commands); });
    ASSERT_TRUE(blas->IsCompacted());
    BlasBuilder::RefitRequest request{blas.get(), Describe(Waves(12, 0.5f), BlasKind::Deforming), true};
    CommandList commands = Device().BeginCommands("refused");
    EXPECT_EQ(testing::ErrorTextOf([&] {
                  builder.RecordRefits(commands, {&request, 1});
              }),
              "BLAS 'mesh': rebuild in the memory of a compacted one");
    request.rebuilds = false;
    Run([&](CommandList& refits) { builder.RecordRefits(refits, {&request, 1}); });
    const std::vector<TestResult> expected = Hits(Build(Describe(Waves(12, 0.5f))));
    const std::vector<TestResult> results = Hits(blas);
    for (size_t i = 0; i < expected.size(); ++i)
        ASSERT_NEAR(results[i].distance, expected[i].distance, 1e-5f) << i;
}

}  // namespace
}  // namespace raygraph::rhi
