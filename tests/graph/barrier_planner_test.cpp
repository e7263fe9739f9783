#include <gtest/gtest.h>

#include "renderer/graph/access.h"
#include "renderer/graph/barrier_planner.h"
#include "renderer/graph/frame_graph.h"
#include "tests/graph/access_table.h"
#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"

// Barriers: the planner's rules one at a time, and the hand-over between passes, frames and queue families as
// text.
namespace raygraph::barrier_planner_test {
namespace {

constexpr VkPipelineStageFlags2 kCompute = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
constexpr VkPipelineStageFlags2 kTracing = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;
constexpr VkPipelineStageFlags2 kTransfer = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
constexpr VkAccessFlags2 kRead = VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
constexpr VkAccessFlags2 kWrite = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
constexpr VkAccessFlags2 kSampledRead = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
constexpr VkAccessFlags2 kUniform = VK_ACCESS_2_UNIFORM_READ_BIT;
constexpr VkImageLayout kGeneral = VK_IMAGE_LAYOUT_GENERAL;
constexpr VkImageLayout kSampledLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
constexpr VkImageLayout kUndefined = VK_IMAGE_LAYOUT_UNDEFINED;

AccessRequest Reading(VkPipelineStageFlags2 stages, VkImageLayout layout = kUndefined,
                      VkAccessFlags2 access = kRead) {
    return {.masks = {stages, access, layout}};
}
AccessRequest Writing(VkPipelineStageFlags2 stages, VkImageLayout layout = kUndefined) {
    return {.masks = {stages, kWrite, layout}, .writes = true, .needsContents = false};
}

// One step after another on one resource, and what the last of them waits for.
struct Rule {
    const char* name;
    std::vector<AccessRequest> steps;
    Dependency expected;  // of the last one; isNeeded is false: nothing
};

TEST(BarrierPlanner, LastStep_WaitsForWhatItMust) {
    const AccessRequest sampling = Reading(kCompute, kSampledLayout, kSampledRead);
    const AccessRequest copying =
        Reading(kTransfer, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_ACCESS_2_TRANSFER_READ_BIT);
    AccessRequest updating = Writing(kCompute, kGeneral);
    updating.needsContents = true;
    const Rule rules[] = {
        {"first use of a buffer", {Writing(kCompute)}, {}},
        {"first use of a texture: a transition that waits for nothing",
         {Writing(kTracing, kGeneral)},
         {.dstStages = kTracing, .dstAccess = kWrite, .newLayout = kGeneral, .isNeeded = true}},
        {"read after write: the write becomes visible",
         {Writing(kTracing), Reading(kCompute)},
         {kTracing, kWrite, kCompute, kRead, kUndefined, kUndefined, true}},
        {"read after read: the write is visible",
         {Writing(kTracing), Reading(kCompute), Reading(kCompute)},
         {}},
        {"a read in another stage waits for the write, not for the reader",
         {Writing(kTracing), Reading(kCompute), Reading(kTransfer)},
         {kTracing, kWrite, kCompute | kTransfer, kRead, kUndefined, kUndefined, true}},
        // Visibility is kept as stages x accesses: two barriers must not vouch for a pair that neither covered.
        {"another access in another stage: the whole product becomes visible",
         {Writing(kTracing), Reading(kCompute, kUndefined, kUniform), Reading(kTransfer)},
         {kTracing, kWrite, kCompute | kTransfer, kRead | kUniform, kUndefined, kUndefined, true}},
        {"a pair of that product",
         {Writing(kTracing), Reading(kCompute, kUndefined, kUniform), Reading(kTransfer), Reading(kCompute)},
         {}},
        {"write after read: execution only",
         {Writing(kTracing), Reading(kCompute), Writing(kTracing)},
         {kCompute, VK_ACCESS_2_NONE, kTracing, kWrite, kUndefined, kUndefined, true}},
        {"write after two readers: both",
         {Writing(kTracing), Reading(kCompute), Reading(kTransfer), Writing(kTracing)},
         {kCompute | kTransfer, VK_ACCESS_2_NONE, kTracing, kWrite, kUndefined, kUndefined, true}},
        {"write after write: the first becomes available",
         {Writing(kTracing), Writing(kCompute)},
         {kTracing, kWrite, kCompute, kWrite, kUndefined, kUndefined, true}},
        {"a write forgets readers before it",
         {Writing(kTracing), Reading(kTransfer), Writing(kCompute), Writing(kTracing)},
         {kCompute, kWrite, kTracing, kWrite, kUndefined, kUndefined, true}},
        {"a reader in another layout: a transition",
         {Writing(kTracing, kGeneral), sampling},
         {kTracing, kWrite, kCompute, kSampledRead, kGeneral, kSampledLayout, true}},
        {"the same reader again", {Writing(kTracing, kGeneral), sampling, sampling}, {}},
        {"another stage in that layout waits for the stage that waited for the transition",
         {Writing(kTracing, kGeneral), sampling, Reading(kTracing, kSampledLayout, kSampledRead)},
         {kCompute, VK_ACCESS_2_NONE, kCompute | kTracing, kSampledRead, kSampledLayout, kSampledLayout,
          true}},
        {"a transition between readers waits for the first",
         {Writing(kTracing, kGeneral), Reading(kCompute, kGeneral), copying},
         {kCompute, VK_ACCESS_2_NONE, kTransfer, VK_ACCESS_2_TRANSFER_READ_BIT, kGeneral,
          VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, true}},
        {"a write that needs no contents drops them",
         {Reading(kCompute, kSampledLayout), Writing(kCompute, kGeneral)},
         {kCompute, VK_ACCESS_2_NONE, kCompute, kWrite, kUndefined, kGeneral, true}},
        {"an update keeps them",
         {Reading(kCompute, kSampledLayout), updating},
         {kCompute, VK_ACCESS_2_NONE, kCompute, kWrite, kSampledLayout, kGeneral, true}}};
    for (const Rule& rule : rules) {
        ResourceState state;
        Dependency last;
        for (const AccessRequest& step : rule.steps) last = PlanAccess(state, step);
        EXPECT_EQ(last.isNeeded, rule.expected.isNeeded) << rule.name;
        if (rule.expected.isNeeded) {
            EXPECT_EQ(last, rule.expected) << rule.name;
        }
    }
}

// Synchronization validation does not see image writes of TraceRays: this is where they are checked.
TEST(Barriers, ImageWrittenByTraceRays_IsWaitedForByEveryKindOfReader) {
    GraphMaker graph;
    TextureId radiance = graph.Texture("radiance");
    graph.AddPass("Trace", PassKind::RayTracing);
    radiance = graph.Use(radiance, Access::StorageWrite);
    graph.AddPass("Sample", PassKind::Raster);
    graph.Use(radiance, Access::Sampled);
    graph.passes.back().keepAlive = true;
    graph.AddPass("Copy", PassKind::Transfer);
    graph.Use(radiance, Access::CopyRead);
    graph.passes.back().keepAlive = true;
    graph.AddPass("Trace again", PassKind::RayTracing);
    radiance = graph.Use(radiance, Access::StorageUpdate);
    graph.passes.back().keepAlive = true;
    const std::string text = graph.Text();
    for (const char* line :
         {"radiance: RayTracingShader write -> RasterShaders read, General -> ShaderReadOnly\n",
          "radiance: RasterShaders done -> Transfer read, ShaderReadOnly -> CopySource\n",
          "radiance: Transfer done -> RayTracingShader read+write, CopySource -> General\n"})
        EXPECT_NE(text.find(line), std::string::npos) << line << text;
}

TEST(Barriers, StructureBuild_IsWaitedForBeforeTracing) {
    GraphMaker graph;
    BlasSetId blases = graph.Imported<ResourceKind::BlasSet>("blases");
    TlasId tlas = graph.Imported<ResourceKind::Tlas>("tlas");
    graph.AddPass("Build BLASes", PassKind::AccelerationStructure);
    blases = graph.Use(blases, Access::BuildWrite);
    graph.AddPass("Build TLAS", PassKind::AccelerationStructure);
    graph.Use(blases, Access::BuildRead);
    tlas = graph.Use(tlas, Access::BuildWrite);
    graph.AddPass("Trace", PassKind::RayTracing);
    graph.Use(tlas, Access::TraceStructure);
    graph.Use(blases, Access::TraceStructure);
    graph.passes.back().keepAlive = true;
    const std::string text = graph.Text();
    for (const char* line : {"blases: StructureBuild write -> StructureBuild read\n",
                             "tlas: StructureBuild write -> RayTracingShader read\n",
                             "blases: StructureBuild write -> RayTracingShader|StructureBuild read\n"})
        EXPECT_NE(text.find(line), std::string::npos) << line << text;
}

TEST(Barriers, PersistentResource_WaitsForItsLastAccessOfTheLastFrame) {
    GraphMaker graph;
    const TextureId mean = graph.Persistent(
        "mean",
        {.writeStages = kCompute, .writeAccess = kWrite, .readStages = kTransfer, .layout = kGeneral});
    graph.AddPass("Accumulate", PassKind::Compute);
    graph.Present(graph.Use(mean, Access::StorageUpdate));
    const std::string text = graph.Text();
    EXPECT_NE(text.find("mean: Transfer done -> ComputeShader read+write, General\n"), std::string::npos)
        << text;
}

TEST(Barriers, ResourceOfAnotherQueueFamily_IsAcquiredAndReleased) {
    GraphMaker graph;
    graph.queueFamily = 0;
    const TextureId host = graph.Imported<ResourceKind::Texture>(
        "host", {.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, .queueFamily = 2});
    graph.Export(graph.Pass("Fill", {}, host), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, 2);
    const Plan plan = Compile(graph);
    EXPECT_EQ(DescribePlan(graph, plan), R"(1 pass, 4 barriers

before the first pass
    waits   host: AllCommands done -> AllCommands read+write, ShaderReadOnly, queue family 2 -> 0

1 Fill (compute)
    writes  host v1 (storage write)
    waits   host: AllCommands done -> ComputeShader write, Undefined -> General

end
    exports host v1
    waits   host: ComputeShader write -> AllCommands read+write, General -> ShaderReadOnly
    waits   host: AllCommands write -> nothing, ShaderReadOnly, queue family 0 -> 2

resources
    host  texture 64x64 rgba8         imported    passes 1-end
)");
    EXPECT_EQ(plan.states[host.resource].queueFamily, 2u);
    EXPECT_EQ(plan.states[host.resource].layout, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

TEST(Barriers, BufferOfAnotherQueueFamily_IsAcquiredAndReleased) {
    GraphMaker graph;
    graph.queueFamily = 0;
    const BufferId host = graph.Imported<ResourceKind::Buffer>("host", {.queueFamily = 2});
    graph.AddPass("Fill", PassKind::Transfer);
    graph.Export(graph.Use(host, Access::CopyWrite), 3);
    const Plan plan = Compile(graph);
    EXPECT_EQ(DescribePlan(graph, plan), R"(1 pass, 4 barriers

before the first pass
    waits   host: AllCommands done -> AllCommands read+write, queue family 2 -> 0

1 Fill (transfer)
    writes  host v1 (copy target)
    waits   host: AllCommands done -> Transfer write

end
    exports host v1
    waits   host: Transfer write -> AllCommands read+write
    waits   host: AllCommands write -> nothing, queue family 0 -> 3

resources
    host  buffer 0 B                  imported    passes 1-end
)");
    EXPECT_EQ(plan.states[host.resource].queueFamily, 3u);
}

// A resource that all families may access changes no owner.
TEST(Barriers, SharedResourceOfAnotherQueueFamily_ChangesNoOwner) {
    GraphMaker graph;
    graph.queueFamily = 0;
    const TextureId host =
        graph.Imported<ResourceKind::Texture>("host", {.writeStages = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                                                       .writeAccess = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                                       .layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                                       .queueFamily = 2});
    graph.resources.back().isShared = true;
    const TextureId target = graph.Texture("target");
    graph.Present(graph.Pass("Read", {host}, target));
    graph.Export(host, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 3);
    const Plan plan = Compile(graph);
    EXPECT_EQ(plan.acquire.count, 0u);
    EXPECT_EQ(plan.release.count, 0u);
    for (const PlannedBarrier& barrier : plan.barriers)
        EXPECT_EQ(barrier.srcQueueFamily, barrier.dstQueueFamily) << BarrierText(graph, barrier);
    ASSERT_GT(plan.passes[0].barriers.count, 0u);
    EXPECT_EQ(BarrierText(graph, plan.barriers[plan.passes[0].barriers.first]),
              "host: Transfer write -> ComputeShader read, CopyTarget -> General");
    EXPECT_EQ(plan.states[host.resource].queueFamily, 3u);
    EXPECT_EQ(plan.states[host.resource].layout, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
}

// The host states no access, and what waits for the other family may be an earlier submission of its own.
TEST(Barriers, SharedResourceOfAnotherQueueFamily_FollowsWhatWaitedForIt) {
    GraphMaker graph;
    graph.queueFamily = 0;
    const TextureId host = graph.Imported<ResourceKind::Texture>(
        "host", {.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, .queueFamily = 2});
    graph.resources.back().isShared = true;
    graph.Present(graph.Pass("Read", {host}, graph.Texture("target")));
    const Plan plan = Compile(graph);
    ASSERT_GT(plan.passes[0].barriers.count, 0u);
    EXPECT_EQ(BarrierText(graph, plan.barriers[plan.passes[0].barriers.first]),
              "host: AllCommands done -> ComputeShader read, CopyTarget -> General");
}

TEST(Barriers, SharedResourceFromOutsideOfTheDevice_IsTransferredFromAndToNoFamily) {
    GraphMaker graph;
    graph.queueFamily = 0;
    const BufferId host =
        graph.Imported<ResourceKind::Buffer>("host", {.queueFamily = VK_QUEUE_FAMILY_EXTERNAL});
    graph.resources.back().isShared = true;
    graph.AddPass("Fill", PassKind::Transfer);
    graph.Export(graph.Use(host, Access::CopyWrite), VK_QUEUE_FAMILY_FOREIGN_EXT);
    const Plan plan = Compile(graph);
    ASSERT_EQ(plan.acquire.count, 1u);
    ASSERT_EQ(plan.release.count, 1u);
    const PlannedBarrier& acquire = plan.barriers[plan.acquire.first];
    const PlannedBarrier& release = plan.barriers[plan.release.first];
    EXPECT_EQ(acquire.srcQueueFamily, VK_QUEUE_FAMILY_EXTERNAL);
    EXPECT_EQ(acquire.dstQueueFamily, VK_QUEUE_FAMILY_IGNORED);
    EXPECT_EQ(release.srcQueueFamily, VK_QUEUE_FAMILY_IGNORED);
    EXPECT_EQ(release.dstQueueFamily, VK_QUEUE_FAMILY_FOREIGN_EXT);
}

TEST(Barriers, ExportedBuffer_KeepsItsWriterAndIsWaitedForWhateverItsOwnerDid) {
    GraphMaker graph;
    const BufferId host = graph.Imported<ResourceKind::Buffer>("host");
    graph.AddPass("Fill", PassKind::Transfer);
    graph.Export(graph.Use(host, Access::CopyWrite));
    EXPECT_EQ(graph.Order(), "Fill");
    EXPECT_EQ(Compile(graph).states[host.resource].writeStages, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { graph.Export(host); }),
        R"(Export hands back "host" as it was before pass "Fill" wrote it: use the id that the write returned)");
    const BufferId own = graph.Buffer("own");
    EXPECT_EQ(testing::ErrorTextOf([&] { graph.Export(own); }),
              R"(Export hands back "own", a transient buffer: only imported ones have an owner)");
}

TEST(Barriers, StructureOfAnotherQueueFamily_IsRefused) {
    GraphMaker graph;
    graph.queueFamily = 0;
    const TlasId tlas = graph.Imported<ResourceKind::Tlas>("host", {.queueFamily = 2});
    graph.AddPass("Trace", PassKind::RayTracing);
    graph.Use(tlas, Access::TraceStructure);
    graph.passes.back().keepAlive = true;
    EXPECT_EQ(testing::ErrorTextOf([&] { Compile(graph); }),
              R"("host", a TLAS, comes from queue family 2: what crosses is the buffer that holds it)");
}

TEST(Barriers, TransitionOfAnImport_DoesNotOvertakeTheSemaphoreOfTheHost) {
    GraphMaker graph;
    graph.waitStages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    const TextureId host = graph.Imported<ResourceKind::Texture>("host");
    graph.Present(graph.Pass("Fill", {}, host));
    EXPECT_NE(graph.Text().find("host: AllCommands done -> ComputeShader write, Undefined -> General\n"),
              std::string::npos)
        << graph.Text();
}

TEST(Barriers, BufferOfAHostThatSomeStagesWaitFor_IsWaitedForByTheOthers) {
    const auto text = [](VkPipelineStageFlags2 waitStages) {
        GraphMaker graph;
        graph.waitStages = waitStages;
        const BufferId host = graph.Imported<ResourceKind::Buffer>("host");
        graph.AddPass("Read", PassKind::RayTracing);
        graph.Use(host, Access::StorageRead);
        graph.passes.back().keepAlive = true;
        return graph.Text();
    };
    EXPECT_NE(text(kCompute).find("host: ComputeShader done -> RayTracingShader read\n"), std::string::npos)
        << text(kCompute);
    EXPECT_EQ(text(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT).find("waits"), std::string::npos);
}

// The host may have written it again since the reads of the frame before, and signals that to some stages.
TEST(Barriers, BufferOfAHostReadBefore_IsWaitedForByReadsInOtherStages) {
    GraphMaker graph;
    graph.waitStages = kCompute;
    const ResourceState readBefore{.writeStages = VK_PIPELINE_STAGE_2_COPY_BIT,
                                   .writeAccess = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                   .readStages = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR,
                                   .visibleStages = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR,
                                   .visibleAccess = VK_ACCESS_2_SHADER_STORAGE_READ_BIT};
    const BufferId host = graph.Imported<ResourceKind::Buffer>("host", readBefore);
    graph.AddPass("Read", PassKind::RayTracing);
    graph.Use(host, Access::StorageRead);
    graph.passes.back().keepAlive = true;
    const Plan plan = Compile(graph);
    ASSERT_EQ(plan.barriers.size(), 1u) << graph.Text();
    EXPECT_NE(plan.barriers[0].dependency.srcStages & kCompute, 0u) << graph.Text();
    EXPECT_EQ(plan.barriers[0].dependency.dstStages, VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR);
}

// A build reads by SHADER_READ, which stands for storage reads too.
TEST(Barriers, ReadThatABroaderOneHasMadeVisible_NeedsNoBarrier) {
    ResourceState state{.writeStages = kCompute, .writeAccess = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT};
    EXPECT_TRUE(PlanAccess(state, {.masks = {kCompute, VK_ACCESS_2_SHADER_READ_BIT}}).isNeeded);
    EXPECT_FALSE(PlanAccess(state, {.masks = {kCompute, VK_ACCESS_2_SHADER_STORAGE_READ_BIT}}).isNeeded);
    EXPECT_TRUE(PlanAccess(state, {.masks = {kCompute, VK_ACCESS_2_INDEX_READ_BIT}}).isNeeded);
}

TEST(Barriers, ShownAndExportedTexture_IsLeftAsItsOwnerAsked) {
    GraphMaker graph;
    const TextureId host = graph.Pass("Fill", {}, graph.Imported<ResourceKind::Texture>("host"));
    graph.Present(host);
    graph.Export(host, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    const Plan plan = Compile(graph);
    EXPECT_EQ(plan.finish.count, 1u);
    EXPECT_EQ(plan.states[host.resource].layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
}

TEST(Barriers, ExportedTexture_IsWaitedForWhateverItsOwnerDid) {
    GraphMaker graph;
    const TextureId host = graph.Imported<ResourceKind::Texture>("host");
    graph.Export(graph.Pass("Fill", {}, host), VK_IMAGE_LAYOUT_GENERAL);
    const ResourceState after = Compile(graph).states[host.resource];

    GraphMaker next;
    const TextureId again = next.Imported<ResourceKind::Texture>("host", after);
    next.Export(next.Pass("Fill", {}, again), VK_IMAGE_LAYOUT_GENERAL);
    EXPECT_NE(next.Text().find("host: AllCommands write -> ComputeShader write, General\n"),
              std::string::npos)
        << next.Text();
}

}  // namespace
}  // namespace raygraph::barrier_planner_test

// Which transients share memory, and how it changes hands.
namespace raygraph::memory_planner_test {
namespace {

uint64_t BlockMebibytes(const Plan& plan) {
    uint64_t bytes = 0;
    for (const rhi::MemoryRequirements& block : plan.blocks) bytes += block.size;
    return bytes >> 20;
}

TEST(Aliasing, DisjointLifetimes_ShareABlock) {
    GraphMaker graph;
    const TextureId a = graph.Pass("A", {}, graph.Texture("a", 8));
    const TextureId b = graph.Pass("B", {a}, graph.Texture("b", 4));
    const TextureId c = graph.Pass("C", {b}, graph.Texture("c", 2));
    graph.Present(c);
    const Plan plan = Compile(graph);
    EXPECT_EQ(plan.blocks.size(), 2u);
    EXPECT_EQ(plan.lifetimes[a.resource].block, plan.lifetimes[c.resource].block);
    EXPECT_EQ(BlockMebibytes(plan), 12u);
    EXPECT_EQ(plan.bytesWithoutAliasing >> 20, 14u);
    EXPECT_NE(graph.Text().find("memory\n    block 0, 8 MiB: a, then c\n    block 1, 4 MiB: b\n"),
              std::string::npos)
        << graph.Text();
}

// A resource read by the pass that writes another lives at the same time as it.
TEST(Aliasing, InputAndOutputOfOnePass_DoNotShare) {
    GraphMaker graph;
    const TextureId a = graph.Pass("A", {}, graph.Texture("a", 8));
    graph.Present(graph.Pass("B", {a}, graph.Texture("b", 8)));
    EXPECT_EQ(Compile(graph).blocks.size(), 2u);
}

TEST(Aliasing, MemoryTypesWithoutACommonBit_DoNotShare) {
    GraphMaker graph;
    const TextureId a = graph.Pass("A", {}, graph.Texture("a", 8, 0b01));
    const TextureId b = graph.Pass("B", {a}, graph.Texture("b", 8, 0b01));
    graph.Present(graph.Pass("C", {b}, graph.Texture("c", 8, 0b10)));
    EXPECT_EQ(Compile(graph).blocks.size(), 3u);
}

TEST(Aliasing, BlockTypes_AreTheIntersectionOfItsOccupants) {
    GraphMaker graph;
    const TextureId a = graph.Pass("A", {}, graph.Texture("a", 8, 0b011));
    const TextureId b = graph.Pass("B", {a}, graph.Texture("b", 8, 0b100));
    const TextureId c = graph.Pass("C", {b}, graph.Texture("c", 4, 0b110));
    const Plan plan = Compile(graph);  // nothing is shown: nothing takes memory
    EXPECT_TRUE(plan.blocks.empty());
    graph.Present(c);
    const Plan shown = Compile(graph);
    ASSERT_EQ(shown.blocks.size(), 2u);
    EXPECT_EQ(shown.blocks[shown.lifetimes[c.resource].block].memoryTypeBits, 0b010u);
}

TEST(Aliasing, PersistentAndImportedResources_TakeNoPart) {
    GraphMaker graph;
    TextureId a = graph.Pass("A", {}, graph.Persistent("a"));
    a = graph.Pass("B", {a}, graph.Imported<ResourceKind::Texture>("b"));
    graph.Present(a);
    EXPECT_TRUE(Compile(graph).blocks.empty());
}

TEST(Aliasing, ShownTransient_KeepsItsMemoryToTheEnd) {
    GraphMaker graph;
    const TextureId a = graph.Pass("A", {}, graph.Texture("a", 8));
    graph.Present(a);
    const TextureId b = graph.Pass("B", {}, graph.Texture("b", 8));
    graph.Present(graph.Pass("C", {b}, graph.Texture("c", 8)));
    const Plan plan = Compile(graph);
    for (const TextureId other : {b})
        EXPECT_NE(plan.lifetimes[other.resource].block, plan.lifetimes[a.resource].block);
}

TEST(Aliasing, BuffersAndTextures_Share) {
    GraphMaker graph;
    BufferId counts = graph.Buffer("counts", 4);
    graph.AddPass("Count", PassKind::Compute);
    counts = graph.Use(counts, Access::StorageWrite);
    graph.AddPass("Sum", PassKind::Compute);
    graph.Use(counts, Access::StorageRead);
    const TextureId sums = graph.Use(graph.Texture("sums", 1), Access::StorageWrite);
    graph.Present(graph.Pass("Show", {sums}, graph.Texture("shown", 2)));
    const std::string text = graph.Text();
    EXPECT_NE(text.find("block 0, 4 MiB: counts, then shown\n"), std::string::npos) << text;
    EXPECT_NE(
        text.find("shown: memory of counts, ComputeShader done -> ComputeShader write, Undefined -> General"),
        std::string::npos)
        << text;
}

// Nothing read `first` after its write, so the hand-over has to make that write available.
TEST(Aliasing, HandOverOfUnreadContents_WaitsForTheWrite) {
    GraphMaker graph;
    const TextureId first = graph.Pass("First", {}, graph.Texture("first", 4), PassKind::RayTracing);
    graph.passes.back().keepAlive = true;
    const TextureId second = graph.Pass("Second", {}, graph.Texture("second", 4));
    graph.Present(second);
    const Plan plan = Compile(graph);
    ASSERT_EQ(plan.blocks.size(), 1u);
    const PlannedBarrier& barrier = plan.barriers[plan.passes[1].barriers.first];
    EXPECT_EQ(barrier.predecessor, first.resource);
    EXPECT_EQ(barrier.dependency.srcStages, VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR);
    EXPECT_EQ(barrier.dependency.srcAccess, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
    EXPECT_EQ(barrier.dependency.oldLayout, VK_IMAGE_LAYOUT_UNDEFINED);
}

// Likewise where others had the memory before it.
TEST(Aliasing, HandOverOfUnreadContentsToAThird_WaitsForTheWrite) {
    GraphMaker graph;
    static_cast<void>(graph.Pass("First", {}, graph.Texture("first", 8), PassKind::RayTracing));
    graph.passes.back().keepAlive = true;
    const TextureId second = graph.Pass("Second", {}, graph.Texture("second", 4));
    graph.passes.back().keepAlive = true;
    graph.Present(graph.Pass("Third", {}, graph.Texture("third", 4)));
    const Plan plan = Compile(graph);
    ASSERT_EQ(plan.blocks.size(), 1u);
    ASSERT_EQ(plan.passes[2].barriers.count, 1u);
    const PlannedBarrier& barrier = plan.barriers[plan.passes[2].barriers.first];
    EXPECT_EQ(barrier.predecessor, second.resource);
    EXPECT_EQ(barrier.dependency.srcStages,
              VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);
    EXPECT_EQ(barrier.dependency.srcAccess, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
}

TEST(Aliasing, NextFrame_WaitsForWhatTheLastOneLeftInTheBlock) {
    std::vector<ResourceState> left;
    for (int frame = 0; frame < 2; ++frame) {
        GraphMaker graph;
        graph.blockStates = left;
        const TextureId a = graph.Pass("A", {}, graph.Texture("a", 4), PassKind::RayTracing);
        graph.AddPass("Look", PassKind::Compute);
        graph.Use(a, Access::StorageRead);
        graph.passes.back().keepAlive = true;
        const std::string text = graph.Text();
        const char* expected = frame == 0 ? "a: first use -> RayTracingShader write, Undefined -> General\n"
                                          : "a: memory of the last frame, ComputeShader done -> "
                                            "RayTracingShader write, Undefined -> General\n";
        EXPECT_NE(text.find(expected), std::string::npos) << text;
        left = Compile(graph).blockStates;
    }
}

TEST(Aliasing, NextFrame_WaitsForEveryOccupantOfTheBlock) {
    GraphMaker first;
    const TextureId large = first.Pass("Large", {}, first.Texture("large", 4), PassKind::RayTracing);
    const TextureId small = first.Pass("Small", {}, first.Texture("small", 1), PassKind::Compute);
    for (GraphPass& pass : first.passes) pass.keepAlive = true;
    const Plan left = Compile(first);
    ASSERT_EQ(left.lifetimes[small.resource].block, left.lifetimes[large.resource].block);

    GraphMaker second;
    second.blockStates = left.blockStates;
    second.Pass("Next", {}, second.Texture("next", 4), PassKind::Compute);
    second.passes.back().keepAlive = true;
    const Plan plan = Compile(second);
    ASSERT_EQ(plan.passes[0].barriers.count, 1u);
    const PlannedBarrier& barrier = plan.barriers[plan.passes[0].barriers.first];
    EXPECT_TRUE(barrier.followsLastFrame);
    EXPECT_EQ(barrier.dependency.srcStages,
              VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);
    EXPECT_EQ(barrier.dependency.srcAccess, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
}

TEST(Aliasing, BlockUnusedForAFrame_KeepsItsState) {
    GraphMaker empty;
    empty.blockStates = {{.writeStages = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT}};
    EXPECT_EQ(Compile(empty).blockStates, empty.blockStates);
}

}  // namespace
}  // namespace raygraph::memory_planner_test

// Masks and layouts of every access against the table written from the specification.
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

TEST(AccessTable, EveryRow_IsTheSpecifications) {
    for (const AccessRow& row : golden::kAccessRows) {
        SCOPED_TRACE(Text(row.kind, row.access));
        const AccessMasks masks = MasksFor(row.kind, row.access);
        EXPECT_EQ(masks.stages, row.stages);
        EXPECT_EQ(masks.access, row.accesses);
        EXPECT_EQ(masks.layout, row.layout);
        EXPECT_EQ(Writes(row.access), row.effect != Effect::Reads);
        EXPECT_EQ(Writes(row.access), (masks.access & kWriteAccesses) != 0);
        EXPECT_EQ(NeedsContents(row.access), row.effect != Effect::Replaces);
    }
}

}  // namespace
}  // namespace raygraph::access_test

// Buffers that shaders reach by the addresses of a uniform block, which the graph fills in.
namespace raygraph::address_table_test {
namespace {

class AddressTableFrame : public GraphTest {
  protected:
    AddressTableFrame() {
        AddShader("test/start.comp", "void main() { sums.at[1] = constants.value; }");
        AddShader("test/table.comp", "void main() { sums.at[0] = constants.value + source.at[1]; }");
    }

    BufferId Run(const char* pass, const char* shader, BufferId source, float value) {
        BufferId sums = m_renderer.CreateBuffer(pass, {.size = 8});
        m_renderer.AddPass(
            pass, PassKind::Compute,
            [&](PassBuilder& builder) {
                builder.Compute(shader);
                if (source.IsValid()) builder.Reads("source", source);
                sums = builder.Writes("sums", sums);
                builder.Constants(value);
            },
            [](CommandList& commands) { commands.Dispatch(1, 1, 1); });
        return sums;
    }

  private:
    void AddShader(const char* name, const char* main) {
        constexpr std::string_view kTables = R"(
#extension GL_EXT_buffer_reference : require
layout(local_size_x = 1) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Source { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Sums { float at[]; };
layout(push_constant, std430) uniform Constants { float value; } constants;
layout(binding = 1, scalar) uniform Tables { Source source; Source unused; Sums sums; };
)";
        m_renderer.AddShader(name, CompileText(name, std::string(kTables) + main));
    }
};

// The second pass waits for the first: a name in a table declares the access as a binding does.
TEST_F(AddressTableFrame, BuffersAreReadAndWrittenFrameAfterFrame) {
    for (const float value : {1.0f, 3.0f, 5.0f, 7.0f}) {
        m_renderer.BeginFrame();
        const BufferId start = Run("Start", "test/start.comp", {}, value);
        const BufferId sum = Run("Add", "test/table.comp", start, value);
        const Readback readback = m_renderer.ReadBack(sum);
        m_renderer.Execute();
        readback.Wait();
        EXPECT_EQ(testing::As<float>(readback.Bytes())[0], 2.0f * value);
    }
}

}  // namespace
}  // namespace raygraph::address_table_test
