// Tests bottom-level structures: batches, compaction, refit, and refusals.
#include <gtest/gtest.h>

#include "rhi/blas_builder.h"
#include "rhi/device.h"
#include "tests/rhi/trace_test.h"
#include "tests/support/error_of.h"
#include "tests/support/padded_structures.h"

namespace raygraph::rhi::blas_test {
namespace {

class BlasTest : public TraceTest {
  protected:
    std::vector<std::shared_ptr<Blas>> AddWaves(BlasBuilder& builder, uint32_t count, uint32_t side = 24) {
        std::vector<std::shared_ptr<Blas>> blases;
        for (uint32_t i = 0; i < count; ++i)
            blases.push_back(builder.Add(Describe(Waves(side + i, 0.1f + 0.05f * static_cast<float>(i)))));
        return blases;
    }

    // Places one instance of each behind the other, and traces 64 x 64 rays through all of them.
    std::vector<TestResult> Hits(const std::vector<std::shared_ptr<Blas>>& blases) {
        std::vector<TlasInstance> instances;
        for (const auto& blas : blases) {
            instances.push_back(Instance(*blas, 0.5f * static_cast<float>(instances.size()),
                                         static_cast<float>(instances.size())));
            instances.back().customIndex = static_cast<uint32_t>(instances.size());
        }
        return Trace(PlainPipeline(), BuildTlas(instances), RayGrid(64));
    }
};

// Compaction saves memory on every driver with these meshes.
class CompactingBlasTest : public BlasTest {
    testing::PaddedStructures padded{Device()};
};

uint32_t HitCount(const std::vector<TestResult>& results) {
    return static_cast<uint32_t>(
        std::count_if(results.begin(), results.end(), [](auto& r) { return r.code == 1; }));
}

TEST_F(CompactingBlasTest, CompactionKeepsEveryHit) {
    BlasBuilder builder(Device(), {.name = "compacting"});
    const std::vector<std::shared_ptr<Blas>> blases = AddWaves(builder, 3);
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    const std::vector<TestResult> before = Hits(blases);
    EXPECT_GT(HitCount(before), 2000u);
    EXPECT_LT(HitCount(before), before.size()) << "some rays miss";
    EXPECT_EQ(builder.Statistics().pending, 3u);

    const VkDeviceAddress oldAddress = blases[0]->Address();
    const uint32_t oldVersion = blases[0]->Version();
    ASSERT_TRUE(builder.Poll());
    Run([&](CommandList& commands) { builder.RecordCompaction(commands); });
    for (const auto& blas : blases) {
        EXPECT_TRUE(blas->IsCompacted());
        EXPECT_LE(blas->Bytes(), blas->BytesBuilt());
    }
    EXPECT_NE(blases[0]->Address(), oldAddress);
    EXPECT_GT(blases[0]->Version(), oldVersion);
    EXPECT_EQ(Hits(blases), before);

    const CompactionStatistics statistics = builder.Statistics();
    EXPECT_EQ(statistics.blasCount, 3u);
    EXPECT_EQ(statistics.pending, 0u);
    EXPECT_EQ(statistics.bytesBuilt,
              blases[0]->BytesBuilt() + blases[1]->BytesBuilt() + blases[2]->BytesBuilt());
    EXPECT_EQ(statistics.bytesCompacted, blases[0]->Bytes() + blases[1]->Bytes() + blases[2]->Bytes());
    EXPECT_FALSE(statistics.isOff);
    RecordProperty("bytesBuilt", std::to_string(statistics.bytesBuilt));
    RecordProperty("bytesCompacted", std::to_string(statistics.bytesCompacted));
    EXPECT_FALSE(builder.Poll()) << "nothing is left to do";
}

TEST_F(BlasTest, CompactionTurnsItselfOffWhereItGainsNothingAndSaysSoOnce) {
    const size_t messagesBefore = Log().Count();
    BlasBuilder builder(Device(), {.name = "default"});
    std::vector<std::shared_ptr<Blas>> blases = AddWaves(builder, 2);
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    const bool hasWork = builder.Poll();
    const CompactionStatistics statistics = builder.Statistics();
    EXPECT_EQ(hasWork, !statistics.isOff);
    if (hasWork) {
        Run([&](CommandList& commands) { builder.RecordCompaction(commands); });
        EXPECT_LT(builder.Statistics().bytesCompacted, statistics.bytesBuilt);
        return;
    }
    EXPECT_EQ(statistics.bytesCompacted, statistics.bytesBuilt);
    EXPECT_EQ(statistics.pending, 0u);
    EXPECT_NE(statistics.disabledReason.find("gains nothing"), std::string::npos)
        << statistics.disabledReason;
    EXPECT_NE(Log().Text(messagesBefore).find("BLAS compaction is off: "), std::string::npos);

    const size_t messagesAfter = Log().Count();
    blases.push_back(builder.Add(Describe(Waves(8))));
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    EXPECT_FALSE(builder.Poll());
    EXPECT_EQ(builder.Statistics().pending, 0u) << "off: nothing is asked any more";
    EXPECT_EQ(Log().Count(), messagesAfter);
}

TEST_F(CompactingBlasTest, PollNeverWaitsForWorkThatIsNotDone) {
    BlasBuilder builder(Device(), {.name = "polling"});
    const std::vector<std::shared_ptr<Blas>> blases = AddWaves(builder, 1);
    CommandList commands = Device().BeginCommands("builds");
    builder.RecordBuilds(commands);
    EXPECT_FALSE(builder.Poll()) << "not even submitted";
    EXPECT_EQ(builder.Statistics().pending, 1u);
    Device().WaitFor(Device().Submit(std::move(commands)));
    EXPECT_TRUE(builder.Poll());
}

TEST_F(CompactingBlasTest, DroppedWhileItsCompactionIsPending_IsLeftOut) {
    BlasBuilder builder(Device(), {.name = "dropping"});
    std::vector<std::shared_ptr<Blas>> blases = AddWaves(builder, 3);
    blases[0].reset();  // is gone before its build
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    EXPECT_EQ(builder.Statistics().buildCount, 2u);
    blases[1].reset();
    ASSERT_TRUE(builder.Poll());
    Run([&](CommandList& commands) { builder.RecordCompaction(commands); });
    EXPECT_EQ(builder.Statistics().blasCount, 1u);
    EXPECT_EQ(builder.Statistics().pending, 0u);
    EXPECT_TRUE(blases[2]->IsCompacted());
}

TEST_F(CompactingBlasTest, BuilderMayGoWhileCompactionIsPending) {
    std::vector<std::shared_ptr<Blas>> blases;
    {
        BlasBuilder builder(Device(), {.name = "short-lived"});
        blases = AddWaves(builder, 2);
        CommandList commands = Device().BeginCommands("builds");
        builder.RecordBuilds(commands);
        Device().WaitFor(Device().Submit(std::move(commands)));
    }
    EXPECT_GT(HitCount(Hits(blases)), 2000u);
}

TEST_F(CompactingBlasTest, DroppedList_LeavesItsBuildsDue) {
    BlasBuilder builder(Device(), {.name = "dropped"});
    const std::vector<std::shared_ptr<Blas>> blases = AddWaves(builder, 2);
    {
        CommandList commands = Device().BeginCommands("dropped");
        builder.RecordBuilds(commands);
        EXPECT_TRUE(blases[0]->IsBuilt()) << "for what else is recorded into the list";
        builder.RecordBuilds(commands);
    }
    EXPECT_FALSE(blases[0]->IsBuilt());
    EXPECT_EQ(blases[0]->Address(), 0u);
    EXPECT_FALSE(builder.Poll());
    EXPECT_EQ(builder.Statistics().pending, 0u);
    EXPECT_EQ(builder.Statistics().buildCount, 0u);
    EXPECT_EQ(builder.Statistics().blasCount, 0u);

    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    EXPECT_EQ(builder.Statistics().buildCount, 2u);
    EXPECT_EQ(builder.Statistics().batchCount, 1u);
    EXPECT_EQ(builder.Statistics().pending, 2u);
    EXPECT_GT(HitCount(Hits(blases)), 2000u);
}

TEST_F(CompactingBlasTest, DroppedList_LeavesItsCompactionsDue) {
    BlasBuilder builder(Device(), {.name = "dropped"});
    const std::vector<std::shared_ptr<Blas>> blases = AddWaves(builder, 3);
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    const std::vector<TestResult> before = Hits(blases);
    ASSERT_TRUE(builder.Poll());
    const VkDeviceAddress address = blases[0]->Address();
    const uint32_t version = blases[0]->Version();
    {
        CommandList commands = Device().BeginCommands("dropped");
        builder.RecordCompaction(commands);
        EXPECT_NE(blases[0]->Address(), address);
    }
    EXPECT_EQ(blases[0]->Address(), address);
    EXPECT_GT(blases[0]->Version(), version) << "who saw the compacted one has to look again";
    EXPECT_FALSE(blases[0]->IsCompacted());
    EXPECT_EQ(builder.Statistics().pending, 3u);
    EXPECT_EQ(Hits(blases), before);

    ASSERT_TRUE(builder.Poll());
    Run([&](CommandList& commands) { builder.RecordCompaction(commands); });
    EXPECT_EQ(builder.Statistics().pending, 0u);
    EXPECT_TRUE(blases[2]->IsCompacted());
    EXPECT_EQ(Hits(blases), before);
}

TEST_F(CompactingBlasTest, CompactionComesInSlicesOfItsBudget) {
    BlasBuilder builder(Device(), {.name = "slices", .compactionBudget = 1});
    const std::vector<std::shared_ptr<Blas>> blases = AddWaves(builder, 3);
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    const std::vector<TestResult> before = Hits(blases);
    for (uint32_t left = 3; left-- > 0;) {
        ASSERT_TRUE(builder.Poll());
        Run([&](CommandList& commands) { builder.RecordCompaction(commands); });
        EXPECT_EQ(builder.Statistics().pending, left) << "each is larger than the budget";
    }
    EXPECT_FALSE(builder.Poll());
    for (const std::shared_ptr<Blas>& blas : blases) EXPECT_TRUE(blas->IsCompacted());
    EXPECT_EQ(Hits(blases), before);
}

TEST_F(CompactingBlasTest, CompactionWithoutMemoryIsTriedAgainLater) {
    BlasBuilder builder(Device(), {.name = "waiting"});
    const std::vector<std::shared_ptr<Blas>> blases = AddWaves(builder, 2);
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    const std::vector<TestResult> before = Hits(blases);
    Device().LimitMemory(Device().Memory().usedBytes);
    bool hadWork = false;
    for (uint32_t i = 0; i < 2 * BlasBuilder::kRetryPolls; ++i) hadWork |= builder.Poll();
    Device().LimitMemory(0);
    EXPECT_FALSE(hadWork);
    EXPECT_EQ(builder.Statistics().pending, 2u);
    EXPECT_EQ(Hits(blases), before) << "what was built is used meanwhile";
    for (uint32_t i = 0; i < BlasBuilder::kRetryPolls && !hadWork; ++i) hadWork = builder.Poll();
    ASSERT_TRUE(hadWork);
    Run([&](CommandList& commands) { builder.RecordCompaction(commands); });
    EXPECT_EQ(builder.Statistics().pending, 0u);
    EXPECT_TRUE(blases[0]->IsCompacted() && blases[1]->IsCompacted());
    EXPECT_EQ(Hits(blases), before);
}

TEST_F(BlasTest, ReservedBuildsTakeNoMoreMemory) {
    BlasBuilder builder(Device(), {.name = "reserved"});
    std::vector<std::shared_ptr<Blas>> blases = AddWaves(builder, 3);
    builder.Reserve();
    const uint64_t reserved = Device().Memory().usedBytes;
    Device().LimitMemory(reserved);
    {
        CommandList dropped = Device().BeginCommands("dropped");
        builder.RecordBuilds(dropped);
    }
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    Device().LimitMemory(0);
    EXPECT_GT(HitCount(Hits(blases)), 2000u);
    Device().WaitIdle();
    EXPECT_LT(Device().Memory().usedBytes, reserved) << "the scratch memory is given back";
}

TEST_F(BlasTest, DroppedList_MayOutliveTheBuilder) {
    CommandList commands = Device().BeginCommands("dropped");
    std::vector<std::shared_ptr<Blas>> blases;
    {
        BlasBuilder builder(Device(), {.name = "short-lived"});
        blases = AddWaves(builder, 1);
        builder.RecordBuilds(commands);
    }
    commands = {};
    EXPECT_FALSE(blases[0]->IsBuilt());
}

TEST_F(BlasTest, BuildsInBatchesUnderTheScratchBudgetHitTheSame) {
    BlasBuilder roomy(Device(), {.name = "roomy", .compacts = false});
    const std::vector<std::shared_ptr<Blas>> together = AddWaves(roomy, 5);
    Run([&](CommandList& commands) { roomy.RecordBuilds(commands); });
    EXPECT_EQ(roomy.Statistics().batchCount, 1u);

    BlasBuilder tight(Device(), {.name = "tight", .scratchBudget = 1, .compacts = false});
    const std::vector<std::shared_ptr<Blas>> apart = AddWaves(tight, 5);
    Run([&](CommandList& commands) { tight.RecordBuilds(commands); });
    EXPECT_EQ(tight.Statistics().batchCount, 5u) << "each is larger than the budget: a batch of its own";
    EXPECT_EQ(tight.Statistics().buildCount, 5u);
    EXPECT_EQ(tight.Statistics().disabledReason, "not asked for");
    EXPECT_EQ(Hits(apart), Hits(together));
}

TEST_F(BlasTest, GeometriesOfOneBlasKeepTheirPrimitiveNumbers) {
    BlasDesc desc = Describe(Quad(0, 0));
    desc.triangles.push_back(Geometry(Quad(0, 1)));
    desc.triangles.push_back(Geometry(Quad(4, 2)));
    const std::shared_ptr<Blas> blas = Build(desc);
    const ShaderStage hit = Compile("geometry.rchit", R"(
        void main() { payload = Payload(1, gl_GeometryIndexEXT, gl_PrimitiveID, gl_HitTEXT); })");
    HitGroupSet set(kRayTypeCount);
    set[RayType::Radiance].closestHit = hit;
    const RayTracingPipeline pipeline =
        CreateRayTracingPipeline(Device(), {.name = "geometry", .rayGen = {RayGen(), {}}, .hitSets = {set}});
    const std::vector<TestResult> results =
        Trace(pipeline, BuildTlas({Instance(*blas)}),
              {{.origin = {-0.5f, 0.2f, -4}}, {.origin = {0.5f, 0.2f, 0.5f}}, {.origin = {4.5f, 0.2f, -4}}});
    EXPECT_EQ(results[0].instance, 0u);
    EXPECT_EQ(results[0].primitive, 0u);
    EXPECT_EQ(results[1].instance, 1u);
    EXPECT_EQ(results[1].primitive, 1u);
    EXPECT_EQ(results[2].instance, 2u);
    EXPECT_FLOAT_EQ(results[2].distance, 6.0f);
}

TEST_F(BlasTest, RefitMovesAHit) {
    BlasBuilder builder(Device(), {.name = "deforming"});
    const TestMesh mesh = Quad(0, 0);
    const BlasDesc desc = Describe(mesh, BlasKind::Deforming);
    const std::vector<std::shared_ptr<Blas>> blases{builder.Add(desc)};
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    EXPECT_FALSE(builder.Poll()) << "Deforming ones are not compacted";
    const RayTracingPipeline& pipeline = PlainPipeline();
    const std::vector<TestRay> rays{{.origin = {0.1f, 0.2f, -4}}, {.origin = {3.1f, 0.2f, -4}}};
    {
        const std::vector<TestResult> results = Trace(pipeline, BuildTlas({Instance(*blases[0])}), rays);
        EXPECT_FLOAT_EQ(results[0].distance, 4.0f);
        EXPECT_EQ(results[1].code, 2u);
    }
    const VkDeviceAddress address = blases[0]->Address();
    for (const auto& [x, z] : {std::pair{0.0f, 2.0f}, std::pair{3.0f, -1.0f}}) {
        const BlasBuilder::RefitRequest request{blases[0].get(), Describe(Quad(x, z), BlasKind::Deforming)};
        Run([&](CommandList& commands) { builder.RecordRefits(commands, {&request, 1}); });
        const std::vector<TestResult> results = Trace(pipeline, BuildTlas({Instance(*blases[0])}), rays);
        EXPECT_EQ(results[0].code, x == 0.0f ? 1u : 2u);
        EXPECT_EQ(results[1].code, x == 0.0f ? 2u : 1u);
        EXPECT_FLOAT_EQ(results[x == 0.0f ? 0 : 1].distance, 4.0f + z);
    }
    EXPECT_EQ(blases[0]->Address(), address) << "updated in place";
    EXPECT_EQ(builder.Statistics().refitCount, 2u);
}

TEST_F(BlasTest, RefitsInBatchesUnderTheScratchBudget) {
    BlasBuilder builder(Device(), {.name = "refits", .scratchBudget = 1});
    std::vector<std::shared_ptr<Blas>> blases;
    std::vector<BlasBuilder::RefitRequest> requests;
    for (uint32_t i = 0; i < 4; ++i) {
        blases.push_back(builder.Add(Describe(Waves(12), BlasKind::Deforming)));
        requests.push_back({blases.back().get(), Describe(Waves(12, 0.5f), BlasKind::Deforming)});
    }
    Run([&](CommandList& commands) {
        builder.RecordBuilds(commands);
        builder.RecordRefits(commands, requests);  // in the same list: the builder synchronizes them
    });
    EXPECT_EQ(builder.Statistics().refitCount, 4u);
    const std::vector<std::shared_ptr<Blas>> fresh{Build(Describe(Waves(12, 0.5f)))};
    const std::vector<TestResult> expected = Hits(fresh);
    for (const auto& blas : blases) {
        const std::vector<TestResult> results = Hits({blas});
        ASSERT_EQ(results.size(), expected.size());
        for (size_t i = 0; i < results.size(); ++i) {
            ASSERT_EQ(results[i].code, expected[i].code) << i;
            ASSERT_NEAR(results[i].distance, expected[i].distance, 1e-5f) << i;
        }
    }
}

TEST_F(BlasTest, IllegalUpdatesAreRefusedBeforeAnythingIsRecorded) {
    BlasBuilder builder(Device(), {.name = "illegal"});
    BlasDesc desc = Describe(Waves(4), BlasKind::Deforming);
    desc.name = "cloth";
    const std::shared_ptr<Blas> cloth = builder.Add(desc);
    const std::shared_ptr<Blas> wall = builder.Add(Describe(Quad(0, 0)));
    CommandList commands = Device().BeginCommands("illegal");
    auto error = [&](Blas& blas, const BlasDesc& next) {
        const BlasBuilder::RefitRequest request{&blas, next};
        return testing::ErrorTextOf([&] { builder.RecordRefits(commands, {&request, 1}); });
    };
    EXPECT_EQ(error(*cloth, desc), "BLAS 'cloth': update before its build");
    builder.RecordBuilds(commands);
    EXPECT_EQ(error(*wall, wall->Desc()),
              "BLAS 'mesh': update of a Static one; only a Deforming one can be updated");

    BlasDesc next = desc;
    next.kind = BlasKind::Static;
    EXPECT_EQ(error(*cloth, next),
              "BLAS 'cloth': update of a Static one; only a Deforming one can be updated");
    next = desc;
    next.triangles[0].triangleCount = 31;
    EXPECT_EQ(error(*cloth, next), "BLAS 'cloth': update changes triangles[0].triangleCount from 32 to 31");
    next = desc;
    next.triangles[0].vertexCount = 24;
    EXPECT_EQ(error(*cloth, next), "BLAS 'cloth': update changes triangles[0].vertexCount from 25 to 24");
    next = desc;
    next.triangles[0].isOpaque = false;
    EXPECT_EQ(error(*cloth, next), "BLAS 'cloth': update changes triangles[0].isOpaque from 1 to 0");
    next = desc;
    next.triangles.push_back(next.triangles[0]);
    EXPECT_EQ(error(*cloth, next), "BLAS 'cloth': update changes triangles.size() from 1 to 2");
    const std::vector<BlasBuilder::RefitRequest> twice{{cloth.get(), desc}, {cloth.get(), desc}};
    EXPECT_EQ(testing::ErrorTextOf([&] { builder.RecordRefits(commands, twice); }),
              "BLAS 'cloth': updated twice in one call");
    EXPECT_EQ(builder.Statistics().refitCount, 0u);
    EXPECT_EQ(error(*cloth, desc), "accepted");
    Device().WaitFor(Device().Submit(std::move(commands)));
}

TEST_F(BlasTest, DescriptionsThatCannotBeBuiltAreRefused) {
    BlasBuilder builder(Device(), {.name = "refusing"});
    const BlasDesc good = Describe(Quad(0, 0));
    auto error = [&](const std::function<void(BlasDesc&)>& change) {
        BlasDesc desc = good;
        change(desc);
        return testing::ErrorTextOf([&] { (void)builder.Add(desc); });
    };
    EXPECT_EQ(error([](BlasDesc&) {}), "accepted");
    EXPECT_EQ(error([](BlasDesc& d) { d.triangles.clear(); }), "BLAS 'mesh': has no geometry");
    EXPECT_EQ(error([](BlasDesc& d) { d.aabbs.push_back({.boxes = 8, .boxCount = 1}); }),
              "BLAS 'mesh': has both triangles and AABBs");
    EXPECT_EQ(error([](BlasDesc& d) { d.triangles[0].triangleCount = 0; }),
              "BLAS 'mesh': triangles[0] is empty");
    EXPECT_EQ(error([](BlasDesc& d) { d.triangles[0].vertices = 0; }),
              "BLAS 'mesh': triangles[0].vertices is null");
    EXPECT_EQ(error([](BlasDesc& d) { d.triangles[0].indices += 2; }),
              "BLAS 'mesh': triangles[0].indices is not a multiple of 4");
    EXPECT_EQ(error([](BlasDesc& d) { d.triangles[0].vertexStride = 10; }),
              "BLAS 'mesh': triangles[0].vertexStride is 10, not a multiple of 4 from 12 up");
    EXPECT_EQ(error([](BlasDesc& d) { d.triangles[0].triangleCount = 1u << 29; }),
              "BLAS 'mesh': has 536870912 primitives, at most 536870911 can be built");
}

}  // namespace
}  // namespace raygraph::rhi::blas_test
