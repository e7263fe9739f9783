// Barriers: the planner's rules one at a time, and the hand-over between passes, frames and queue families as
// text.
#include "renderer/graph/barrier_planner.h"

#include "tests/graph/graph_maker.h"
#include "tests/support/error_of.h"

namespace raygraph::barrier_planner_test {
namespace {

constexpr VkPipelineStageFlags2 kCompute = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
constexpr VkPipelineStageFlags2 kTracing = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;
constexpr VkPipelineStageFlags2 kTransfer = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
constexpr VkAccessFlags2 kRead = VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
constexpr VkAccessFlags2 kWrite = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
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

TEST(BarrierPlanner, FirstUse_NeedsNoBarrierForABuffer) {
    ResourceState state;
    EXPECT_FALSE(PlanAccess(state, Writing(kCompute)).isNeeded);
}

TEST(BarrierPlanner, FirstUse_OfATextureIsATransitionThatWaitsForNothing) {
    ResourceState state;
    EXPECT_EQ(PlanAccess(state, Writing(kTracing, kGeneral)), (Dependency{.dstStages = kTracing,
                                                                          .dstAccess = kWrite,
                                                                          .oldLayout = kUndefined,
                                                                          .newLayout = kGeneral,
                                                                          .isNeeded = true}));
    EXPECT_EQ(state.layout, kGeneral);
}

TEST(BarrierPlanner, ReadAfterWrite_MakesTheWriteVisible) {
    ResourceState state;
    PlanAccess(state, Writing(kTracing));
    EXPECT_EQ(PlanAccess(state, Reading(kCompute)), (Dependency{.srcStages = kTracing,
                                                                .srcAccess = kWrite,
                                                                .dstStages = kCompute,
                                                                .dstAccess = kRead,
                                                                .isNeeded = true}));
}

TEST(BarrierPlanner, ReadAfterRead_NeedsNothingWhereTheWriteIsVisible) {
    ResourceState state;
    PlanAccess(state, Writing(kTracing));
    PlanAccess(state, Reading(kCompute));
    EXPECT_FALSE(PlanAccess(state, Reading(kCompute)).isNeeded);
}

TEST(BarrierPlanner, ReadInAnotherStage_WaitsForTheWriteNotForTheReader) {
    ResourceState state;
    PlanAccess(state, Writing(kTracing));
    PlanAccess(state, Reading(kCompute));
    const Dependency second = PlanAccess(state, Reading(kTransfer));
    EXPECT_EQ(second.srcStages, kTracing);
    EXPECT_EQ(second.srcAccess, kWrite);
    EXPECT_TRUE((second.dstStages & kTransfer) != 0);
}

// Visibility is kept as stages x accesses: two barriers must not vouch for a pair that neither covered.
TEST(BarrierPlanner, VisibilityOfTwoReaders_IsTheWholeProduct) {
    ResourceState state;
    PlanAccess(state, Writing(kTracing));
    PlanAccess(state, Reading(kCompute, kUndefined, VK_ACCESS_2_UNIFORM_READ_BIT));
    const Dependency second = PlanAccess(state, Reading(kTransfer, kUndefined, kRead));
    EXPECT_EQ(second.dstStages, kCompute | kTransfer);
    EXPECT_EQ(second.dstAccess, kRead | VK_ACCESS_2_UNIFORM_READ_BIT);
    EXPECT_FALSE(PlanAccess(state, Reading(kCompute, kUndefined, kRead)).isNeeded);
}

TEST(BarrierPlanner, WriteAfterRead_IsExecutionOnly) {
    ResourceState state;
    PlanAccess(state, Writing(kTracing));
    PlanAccess(state, Reading(kCompute));
    EXPECT_EQ(
        PlanAccess(state, Writing(kTracing)),
        (Dependency{.srcStages = kCompute, .dstStages = kTracing, .dstAccess = kWrite, .isNeeded = true}));
}

TEST(BarrierPlanner, WriteAfterTwoReaders_WaitsForBoth) {
    ResourceState state;
    PlanAccess(state, Writing(kTracing));
    PlanAccess(state, Reading(kCompute));
    PlanAccess(state, Reading(kTransfer));
    EXPECT_EQ(PlanAccess(state, Writing(kTracing)).srcStages, kCompute | kTransfer);
}

TEST(BarrierPlanner, WriteAfterWrite_MakesTheFirstAvailable) {
    ResourceState state;
    PlanAccess(state, Writing(kTracing));
    const Dependency second = PlanAccess(state, Writing(kCompute));
    EXPECT_EQ(second.srcStages, kTracing);
    EXPECT_EQ(second.srcAccess, kWrite);
}

TEST(BarrierPlanner, WriteForgetsReadersBeforeIt) {
    ResourceState state;
    PlanAccess(state, Writing(kTracing));
    PlanAccess(state, Reading(kTransfer));
    PlanAccess(state, Writing(kCompute));
    EXPECT_EQ(PlanAccess(state, Writing(kTracing)).srcStages, kCompute);
}

TEST(BarrierPlanner, LayoutChangeForAReader_IsATransitionLaterReadersChainTo) {
    ResourceState state;
    PlanAccess(state, Writing(kTracing, kGeneral));
    const AccessRequest sampling = Reading(kCompute, kSampledLayout, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
    const Dependency transition = PlanAccess(state, sampling);
    EXPECT_EQ(transition.oldLayout, kGeneral);
    EXPECT_EQ(transition.newLayout, kSampledLayout);
    EXPECT_EQ(transition.srcAccess, kWrite);
    EXPECT_FALSE(PlanAccess(state, sampling).isNeeded);
    // Another stage in the same layout waits for the stage that waited for the transition.
    const Dependency other =
        PlanAccess(state, Reading(kTracing, kSampledLayout, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT));
    EXPECT_TRUE(other.isNeeded);
    EXPECT_EQ(other.srcStages, kCompute);
    EXPECT_EQ(other.oldLayout, other.newLayout);
}

TEST(BarrierPlanner, LayoutChangeBetweenReaders_WaitsForTheFirstReader) {
    ResourceState state;
    PlanAccess(state, Writing(kTracing, kGeneral));
    PlanAccess(state, Reading(kCompute, kGeneral));
    const Dependency transition = PlanAccess(
        state, Reading(kTransfer, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_ACCESS_2_TRANSFER_READ_BIT));
    EXPECT_EQ(transition.srcStages, kCompute);
    EXPECT_EQ(transition.srcAccess, VK_ACCESS_2_NONE);
}

TEST(BarrierPlanner, WriteThatNeedsNoContents_DropsThemInATransition) {
    ResourceState state;
    PlanAccess(state, Reading(kCompute, kSampledLayout));
    EXPECT_EQ(PlanAccess(state, Writing(kCompute, kGeneral)).oldLayout, kUndefined);

    AccessRequest update = Writing(kCompute, kGeneral);
    update.needsContents = true;
    ResourceState kept;
    PlanAccess(kept, Reading(kCompute, kSampledLayout));
    EXPECT_EQ(PlanAccess(kept, update).oldLayout, kSampledLayout);
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

// What a build reads is SHADER_READ, which stands for storage reads too.
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
