// Which transients share memory, and how it changes hands.
#include "tests/graph/graph_maker.h"

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
