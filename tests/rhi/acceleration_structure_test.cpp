#include <gtest/gtest.h>
#include <algorithm>
#include <cstring>
#include <limits>

#include "rhi/blas_builder.h"
#include "rhi/device.h"
#include "rhi/tlas.h"
#include "tests/rhi/fake_loader.h"
#include "tests/rhi/trace_test.h"
#include "tests/support/error_of.h"
#include "tests/support/padded_structures.h"

// Tests bottom-level structures: batches, compaction, refit, and refusals.
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

// Tests deforming structures: in-place rebuilds, compaction, and the memory that these take.
namespace raygraph::rhi::blas_rebuild_test {
namespace {

class BlasRebuild : public TraceTest {
  protected:
    std::vector<TestResult> Hits(const std::shared_ptr<Blas>& blas) {
        return Trace(PlainPipeline(), BuildTlas({Instance(*blas)}), RayGrid(64));
    }
};

// Has one triangle many times, on a device whose builds need more scratch memory than updates.
class RefitScratch : public ::testing::Test {
  protected:
    static constexpr uint64_t kBuildScratch = 1u << 20;

    RefitScratch() {
        loader.Tell().buildScratchBytes = kBuildScratch;
        DeviceDesc desc;
        desc.getInstanceProcAddr = loader.Entry();
        desc.savePipelineCache = false;
        device = Device::Create(desc);
        vertices = Upload("vertices", std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0});
        indices = Upload("indices", std::vector<uint32_t>{0, 1, 2});
    }
    template <typename T>
    Buffer Upload(const char* name, const std::vector<T>& data) {
        Buffer buffer = device->CreateBuffer({.name = name,
                                              .size = data.size() * sizeof(T),
                                              .usage = BufferUsage::BuildInput,
                                              .memory = MemoryKind::Upload});
        std::ranges::copy(std::as_bytes(std::span(data)), buffer.Mapped().begin());
        return buffer;
    }
    std::vector<std::shared_ptr<Blas>> AddTriangles(BlasBuilder& builder, uint32_t count) {
        const BlasDesc desc{.name = "triangle",
                            .kind = BlasKind::Deforming,
                            .triangles = {{.vertices = vertices.Address(),
                                           .vertexCount = 3,
                                           .indices = indices.Address(),
                                           .triangleCount = 1}}};
        std::vector<std::shared_ptr<Blas>> blases;
        for (uint32_t i = 0; i < count; ++i) blases.push_back(builder.Add(desc));
        Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
        loader.Tell().builds.clear();
        return blases;
    }
    void Run(const std::function<void(CommandList&)>& record) {
        CommandList commands = device->BeginCommands("test");
        record(commands);
        device->WaitFor(device->Submit(std::move(commands)));
    }
    uint64_t UsedBytes() {
        device->WaitIdle();
        device->CollectGarbage();
        return device->Memory().usedBytes;
    }

    testing::FakeLoader loader;
    std::unique_ptr<Device> device;
    Buffer vertices, indices;
};

// Makes two quads, of which the second is NaN unless it is asked for.
TestMesh OneOrTwoQuads(bool hasSecond) {
    TestMesh mesh = Quad(0, 0), second = Quad(3, -1);
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    for (std::array<float, 3>& vertex : second.vertices) {
        if (!hasSecond) vertex[0] = std::numeric_limits<float>::quiet_NaN();
        mesh.vertices.push_back(vertex);
    }
    for (const uint32_t index : second.indices) mesh.indices.push_back(first + index);
    return mesh;
}

// Triangles appear, which no update can do. Where drivers update by a rebuild, the tests of RefitScratch tell
// the two apart.
TEST_F(BlasRebuild, RebuildInPlaceShowsNewTrianglesAndKeepsTheAddress) {
    BlasBuilder builder(Device(), {.name = "deforming"});
    const std::shared_ptr<Blas> blas = builder.Add(Describe(OneOrTwoQuads(false), BlasKind::Deforming));
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    const VkDeviceAddress address = blas->Address();
    const std::vector<TestRay> rays{{.origin = {0.1f, 0.2f, -4}}, {.origin = {3.1f, 0.2f, -4}}};
    std::vector<TestResult> results = Trace(PlainPipeline(), BuildTlas({Instance(*blas)}), rays);
    EXPECT_EQ(results[1].code, 2u);
    const std::vector<BlasBuilder::RefitRequest> requests{
        {blas.get(), Describe(OneOrTwoQuads(true), BlasKind::Deforming), true}};
    Run([&](CommandList& commands) { builder.RecordRefits(commands, requests); });
    results = Trace(PlainPipeline(), BuildTlas({Instance(*blas)}), rays);
    EXPECT_FLOAT_EQ(results[0].distance, 4.0f);
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

TEST_F(RefitScratch, UpdatesOfAllShareABatchAndRebuildsTakeTurnsWithoutMoreMemory) {
    BlasBuilder builder(*device, {.name = "tight", .scratchBudget = kBuildScratch});
    const std::vector<std::shared_ptr<Blas>> blases = AddTriangles(builder, 4);
    std::vector<BlasBuilder::RefitRequest> requests;
    for (const std::shared_ptr<Blas>& blas : blases) requests.push_back({.blas = blas.get()});
    constexpr auto kBuild = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    constexpr auto kUpdate = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    using Batches = std::vector<std::vector<VkBuildAccelerationStructureModeKHR>>;
    device->LimitMemory(UsedBytes());
    Run([&](CommandList& commands) { builder.RecordRefits(commands, requests); });
    EXPECT_EQ(loader.Tell().builds, (Batches{{kUpdate, kUpdate, kUpdate, kUpdate}}));
    loader.Tell().builds.clear();
    for (const size_t i : {0, 1, 3}) requests[i].rebuilds = true;
    Run([&](CommandList& commands) { builder.RecordRefits(commands, requests); });
    EXPECT_EQ(loader.Tell().builds, (Batches{{kBuild}, {kBuild}, {kUpdate}, {kBuild}}));
    EXPECT_EQ(builder.Statistics().rebuildCount, 3u);
    EXPECT_EQ(builder.Statistics().refitCount, 5u);
}

TEST_F(RefitScratch, IsThatOfTheLargestRebuildUntilNoDeformingOneIsLeft) {
    BlasBuilder builder(*device, {.name = "scratch"});
    std::vector<std::shared_ptr<Blas>> blases = AddTriangles(builder, 8);
    const uint64_t built = UsedBytes();
    builder.Trim();
    EXPECT_EQ(UsedBytes(), built) << "they may be refitted";
    blases.clear();
    const uint64_t withScratch = UsedBytes();
    builder.Trim();
    const uint64_t scratch = withScratch - UsedBytes();
    EXPECT_GE(scratch, kBuildScratch);
    EXPECT_LT(scratch, 2 * kBuildScratch);
    blases = AddTriangles(builder, 1);
    const BlasBuilder::RefitRequest request{.blas = blases[0].get(), .desc = {}, .rebuilds = true};
    Run([&](CommandList& commands) { builder.RecordRefits(commands, {&request, 1}); });
    EXPECT_EQ(builder.Statistics().rebuildCount, 1u);
}

// The vertices have moved within the buffer of the build.
TEST_F(BlasRebuild, RefitsWithoutADescriptionReadTheBuffersOfTheBuild) {
    BlasBuilder builder(Device(), {.name = "same buffers"});
    TestMesh mesh = Quad(0, 0);
    BlasDesc desc = Describe(mesh, BlasKind::Deforming);
    const Buffer vertices = Upload("vertices", mesh.vertices, BufferUsage::BuildInput);
    desc.triangles[0].vertices = vertices.Address();
    const std::shared_ptr<Blas> blas = builder.Add(desc);
    Run([&](CommandList& commands) { builder.RecordBuilds(commands); });
    mesh = Quad(0, 2);
    std::memcpy(vertices.Mapped().data(), mesh.vertices.data(),
                mesh.vertices.size() * sizeof(mesh.vertices[0]));
    const BlasBuilder::RefitRequest request{.blas = blas.get()};
    Run([&](CommandList& commands) { builder.RecordRefits(commands, {&request, 1}); });
    EXPECT_FLOAT_EQ(
        Trace(PlainPipeline(), BuildTlas({Instance(*blas)}), {{.origin = {0.1f, 0.2f, -4}}})[0].distance,
        6.0f);
}

}  // namespace
}  // namespace raygraph::rhi::blas_rebuild_test

// Tests top-level structures: build, update, and instances as the device reads them.
namespace raygraph::rhi::tlas_test {
namespace {

class TlasTest : public TraceTest {
  protected:
    std::shared_ptr<Blas> m_quad = Build(Describe(Quad(0, 0)));
};

TEST_F(TlasTest, UpdateMovesAHit) {
    Tlas tlas = BuildTlas({Instance(*m_quad, 0), Instance(*m_quad, 10)});
    const RayTracingPipeline& pipeline = PlainPipeline();
    const std::vector<TestRay> rays{
        {.origin = {0, 0.1f, -4}}, {.origin = {5, 0.1f, -4}}, {.origin = {10, 0.1f, -4}}};
    auto codes = [&] {
        std::vector<uint32_t> out;
        for (const TestResult& result : Trace(pipeline, tlas, rays)) out.push_back(result.code);
        return out;
    };
    EXPECT_EQ(codes(), (std::vector<uint32_t>{1, 2, 1}));
    const VkDeviceAddress address = tlas.Address();
    const Buffer moved = Instances({Instance(*m_quad, 5), Instance(*m_quad, 10)});
    Run([&](CommandList& commands) { tlas.Update(commands, moved, 2); });
    EXPECT_EQ(codes(), (std::vector<uint32_t>{2, 1, 1}));
    EXPECT_EQ(tlas.Address(), address);

    const Buffer fewer = Instances({Instance(*m_quad, 0)});
    Run([&](CommandList& commands) { tlas.Build(commands, fewer, 1); });  // within the capacity
    EXPECT_EQ(tlas.InstanceCount(), 1u);
    EXPECT_EQ(codes(), (std::vector<uint32_t>{1, 2, 2}));
}

TEST_F(TlasTest, BuildAndUpdateInOneListAreOrdered) {
    const Buffer first = Instances({Instance(*m_quad, 0)});
    const Buffer second = Instances({Instance(*m_quad, 5)});
    Tlas tlas(Device(), {.name = "moving", .capacity = 1});
    Run([&](CommandList& commands) {
        tlas.Build(commands, first, 1);
        tlas.Update(commands, second, 1);
    });
    EXPECT_EQ(Trace(PlainPipeline(), tlas, {{.origin = {5, 0.1f, -4}}})[0].code, 1u);
}

TEST_F(TlasTest, DroppedList_TakesItsBuildsBack) {
    const Buffer one = Instances({Instance(*m_quad, 0)});
    const Buffer two = Instances({Instance(*m_quad, 0), Instance(*m_quad, 5)});
    Tlas tlas(Device(), {.name = "dropped", .capacity = 2});
    {
        CommandList commands = Device().BeginCommands("dropped");
        tlas.Build(commands, two, 2);
        tlas.Update(commands, two, 2);
    }
    EXPECT_EQ(tlas.InstanceCount(), 0u);
    CommandList commands = Device().BeginCommands("update");
    EXPECT_EQ(testing::ErrorTextOf([&] { tlas.Update(commands, two, 2); }),
              "TLAS 'dropped': update before its first build");
    tlas.Build(commands, one, 1);
    Device().WaitFor(Device().Submit(std::move(commands)));
    EXPECT_EQ(tlas.InstanceCount(), 1u);
    EXPECT_EQ(Trace(PlainPipeline(), tlas, {{.origin = {0, 0.1f, -4}}})[0].code, 1u);
}

TEST_F(TlasTest, TransformIsRowMajorObjectToWorld) {
    TlasInstance instance = Instance(*m_quad);
    // x' = 2 z + 3, y' = y, z' = x: the quad turns into the plane x = 3 and faces along x.
    instance.objectToWorld = {0, 0, 2, 3, 0, 1, 0, 0, 1, 0, 0, 0};
    const std::vector<TestResult> results =
        Trace(PlainPipeline(), BuildTlas({instance}), {{.origin = {0, 0.1f, 0.5f}, .direction = {1, 0, 0}}});
    EXPECT_EQ(results[0].code, 1u);
    EXPECT_FLOAT_EQ(results[0].distance, 3.0f);
}

TEST_F(TlasTest, NoInstancesMeansThatEveryRayMisses) {
    for (const TestResult& result : Trace(PlainPipeline(), BuildTlas({}), RayGrid(4)))
        EXPECT_EQ(result.code, 2u);
}

TEST_F(TlasTest, MaskZeroAndInactiveInstancesAreNeverHit) {
    TlasInstance masked = Instance(*m_quad, 0);
    masked.mask = 0;
    TlasInstance inactive = Instance(*m_quad, 4);
    inactive.blas = 0;
    const std::vector<TestResult> results =
        Trace(PlainPipeline(), BuildTlas({masked, inactive, Instance(*m_quad, 8)}),
              {{.origin = {0, 0.1f, -4}}, {.origin = {4, 0.1f, -4}}, {.origin = {8, 0.1f, -4}}});
    EXPECT_EQ(results[0].code, 2u);
    EXPECT_EQ(results[1].code, 2u);
    EXPECT_EQ(results[2].code, 1u);
}

TEST_F(TlasTest, FrontFaceIsCounterClockwiseUnlessFlippedAndMirroringKeepsIt) {
    const ShaderStage hit = Compile("facing.rchit", R"(
        void main() { payload.code = gl_HitKindEXT == gl_HitKindFrontFacingTriangleEXT ? 5 : 6; })");
    HitGroupSet set(kRayTypeCount);
    set[RayType::Radiance].closestHit = hit;
    const RayTracingPipeline pipeline =
        CreateRayTracingPipeline(Device(), {.name = "facing", .rayGen = {RayGen(), {}}, .hitSets = {set}});
    // Seen from -z along +z with y up, +x is to the left: (-1,-1), (-1,1), (1,1) turn counter-clockwise.
    const TlasInstance plain = Instance(*m_quad, 0);
    TlasInstance flipped = Instance(*m_quad, 4);
    flipped.isFacingFlipped = true;
    TlasInstance mirrored = Instance(*m_quad, 8);
    mirrored.objectToWorld[0] = -1.0f;
    std::vector<TestRay> rays;
    for (float x : {0.0f, 4.0f, 8.0f})
        for (float side : {-1.0f, 1.0f})
            rays.push_back({.origin = {x, 0.1f, 4 * side}, .direction = {0, 0, -side}});
    std::vector<uint32_t> codes;
    for (const TestResult& result : Trace(pipeline, BuildTlas({plain, flipped, mirrored}), rays))
        codes.push_back(result.code);
    EXPECT_EQ(codes, (std::vector<uint32_t>{5, 6, 6, 5, 5, 6}));
}

TEST_F(TlasTest, CullingFollowsTheFacingWhereItIsNotDisabled) {
    const ShaderStage rayGen = Compile("cull.rgen", R"(
        void main() {
            Ray ray = rays[gl_LaunchIDEXT.x];
            payload = Payload(~0u, ~0u, ~0u, -1.0);
            traceRayEXT(tlas, gl_RayFlagsCullBackFacingTrianglesEXT, 0xff, 0, 0, 0, ray.origin, 0.0,
                        ray.direction, 1e9, 0);
            results[gl_LaunchIDEXT.x] = payload;
        })");
    HitGroupSet set(kRayTypeCount);
    set[RayType::Radiance].closestHit = ClosestHit("cull", 1);
    const RayTracingPipeline pipeline =
        CreateRayTracingPipeline(Device(), {.name = "cull", .rayGen = {rayGen, {}}, .hitSets = {set}});
    TlasInstance culled = Instance(*m_quad, 0);
    culled.isCullingDisabled = false;
    const std::vector<TestResult> results = Trace(pipeline, BuildTlas({culled, Instance(*m_quad, 4)}),
                                                  {{.origin = {0, 0.1f, -4}},
                                                   {.origin = {0, 0.1f, 4}, .direction = {0, 0, -1}},
                                                   {.origin = {4, 0.1f, 4}, .direction = {0, 0, -1}}});
    EXPECT_EQ(results[0].code, 1u) << "front";
    EXPECT_EQ(results[1].code, kUntouched) << "back";
    EXPECT_EQ(results[2].code, 1u) << "back, culling disabled";
}

TEST_F(TlasTest, MisuseIsRefusedByName) {
    Tlas tlas(Device(), {.name = "small", .capacity = 2});
    Tlas rigid(Device(), {.name = "rigid", .capacity = 2, .allowsUpdate = false});
    const Buffer three = Instances({Instance(*m_quad), Instance(*m_quad), Instance(*m_quad)});
    const Buffer one = Instances({Instance(*m_quad)});
    Run([&](CommandList& commands) {
        EXPECT_EQ(testing::ErrorTextOf([&] { tlas.Build(commands, three, 3); }),
                  "TLAS 'small': 3 instances exceed its capacity of 2");
        EXPECT_EQ(testing::ErrorTextOf([&] { tlas.Build(commands, one, 2); }),
                  "TLAS 'small': 2 instances exceed buffer 'instances' of 64 bytes");
        EXPECT_EQ(testing::ErrorTextOf([&] { tlas.Update(commands, three, 2); }),
                  "TLAS 'small': update before its first build");
        tlas.Build(commands, three, 2);
        EXPECT_EQ(testing::ErrorTextOf([&] { tlas.Update(commands, three, 1); }),
                  "TLAS 'small': update with 1 instances, built with 2");
        rigid.Build(commands, three, 2);
        EXPECT_EQ(testing::ErrorTextOf([&] { rigid.Update(commands, three, 2); }),
                  "TLAS 'rigid': update, but it was made without allowsUpdate");
    });
}

TEST_F(TlasTest, InstanceFieldsBeyond24BitsAreRefusedWithTheirPlace) {
    std::vector<std::byte> target(2 * kTlasInstanceBytes);
    std::vector<TlasInstance> instances(2);
    instances[1].customIndex = 0xffffff;
    EXPECT_EQ(testing::ErrorTextOf([&] { WriteInstances(instances, target); }), "accepted");
    instances[1].customIndex = 0x1000000;
    EXPECT_EQ(testing::ErrorTextOf([&] { WriteInstances(instances, target); }),
              "TLAS instance 1: customIndex 16777216 or hitRecord 0 exceeds 24 bits");
    instances[1].customIndex = 0;
    instances[1].hitRecord = 0x1000000;
    EXPECT_EQ(testing::ErrorTextOf([&] { WriteInstances(instances, target); }),
              "TLAS instance 1: customIndex 0 or hitRecord 16777216 exceeds 24 bits");
    instances[1].hitRecord = 0;
    target.pop_back();
    EXPECT_EQ(testing::ErrorTextOf([&] { WriteInstances(instances, target); }),
              "2 TLAS instances do not fit 127 bytes");
}

}  // namespace
}  // namespace raygraph::rhi::tlas_test
