// Textures of several levels and layers, without a device: what is culled, and the
// barriers of each part, as text.
#include <algorithm>
#include <array>

#include "renderer/graph/barrier_merge.h"
#include "tests/graph/graph_maker.h"

namespace raygraph::subresource_test {
namespace {

constexpr VkPipelineStageFlags2 kCompute = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
constexpr VkPipelineStageFlags2 kTracing = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;
constexpr VkPipelineStageFlags2 kTransfer = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
constexpr VkAccessFlags2 kWrite = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
constexpr VkImageLayout kGeneral = VK_IMAGE_LAYOUT_GENERAL;

// The lines of the plan that tell of barriers, with the names of their passes.
std::string Waits(const FrameGraph& graph, const Plan& plan) {
    std::string text;
    const auto range = [&](const std::string& before, const BarrierRange& barriers) {
        for (uint32_t b = barriers.first; b < barriers.first + barriers.count; ++b)
            text += before + ": " + BarrierText(graph, plan.barriers[b]) + '\n';
    };
    for (const PlannedPass& planned : plan.passes) range(graph.passes[planned.pass].name, planned.barriers);
    range("end", plan.finish);
    return text;
}
std::string Waits(const FrameGraph& graph) {
    return Waits(graph, Compile(graph));
}

TEST(Subresources, ChainOfLevels_WaitsLevelByLevel) {
    GraphMaker graph;
    TextureId chain = graph.Fill("Draw", graph.Chain("chain", 3, 1, 1), Level(0));
    chain = graph.Step("Halve", chain, Level(0), Level(1));
    chain = graph.Step("Quarter", chain, Level(1), Level(2));
    TextureId shown = graph.Texture("shown");
    graph.AddPass("Show", PassKind::Compute);
    graph.Use(chain, Access::Sampled);
    shown = graph.Use(shown, Access::StorageWrite);
    graph.Present(shown);

    EXPECT_EQ(graph.Text(), R"(4 passes, 9 barriers, 1 MiB of transient memory

1 Draw (compute)
    writes  chain v1 level 0 (storage write)
    waits   chain level 0: first use -> ComputeShader write, Undefined -> General

2 Halve (compute)
    reads   chain v1 level 0 (storage read)
    writes  chain v2 level 1 (storage write)
    waits   chain level 0: ComputeShader write -> ComputeShader read, General
    waits   chain level 1: first use -> ComputeShader write, Undefined -> General

3 Quarter (compute)
    reads   chain v2 level 1 (storage read)
    writes  chain v3 level 2 (storage write)
    waits   chain level 1: ComputeShader write -> ComputeShader read, General
    waits   chain level 2: first use -> ComputeShader write, Undefined -> General

4 Show (compute)
    reads   chain v3 (sampled)
    writes  shown v1 (storage write)
    waits   chain levels 0-1: ComputeShader done -> ComputeShader read, General -> ShaderReadOnly
    waits   chain level 2: ComputeShader write -> ComputeShader read, General -> ShaderReadOnly
    waits   shown: first use -> ComputeShader write, Undefined -> General

end
    shows   shown v1
    waits   shown: ComputeShader write -> FragmentShader read, General -> ShaderReadOnly

resources
    chain  texture 64x64 rgba32f, 3 levels transient   passes 1-4
    shown  texture 64x64 rgba32f       transient   passes 4-end

memory
    block 0, 1 MiB: chain
)");
}

// A pass may see two levels in two layouts: what it filters from is sampled.
TEST(Subresources, LevelsOfOnePass_HaveTheirOwnLayouts) {
    GraphMaker graph;
    TextureId chain = graph.Fill("Draw", graph.Chain("chain", 2), Level(0));
    chain = graph.Step("Halve", chain, Level(0), Level(1), Access::Sampled);
    graph.passes.back().keepAlive = true;
    EXPECT_EQ(Waits(graph),
              "Draw: chain level 0: first use -> ComputeShader write, Undefined -> General\n"
              "Halve: chain level 0: ComputeShader write -> ComputeShader read, General -> ShaderReadOnly\n"
              "Halve: chain level 1: first use -> ComputeShader write, Undefined -> General\n");
}

TEST(Subresources, WholeAfterParts_WaitsForEach_AndPartsAfterItForItAlone) {
    GraphMaker graph;
    TextureId layers = graph.Chain("layers", 1, 4);
    graph.AddPass("Copy", PassKind::Transfer);
    layers = graph.Use(layers, Access::CopyWrite, Layers(0, 2));
    layers = graph.Fill("Fill", layers, Layers(2, 2));
    graph.Look("Sample", layers);
    layers = graph.Fill("Whole", layers);
    graph.Look("Part", layers, Layer(3), Access::StorageRead);
    EXPECT_EQ(
        Waits(graph),
        "Copy: layers layers 0-1: first use -> Transfer write, Undefined -> CopyTarget\n"
        "Fill: layers layers 2-3: first use -> ComputeShader write, Undefined -> General\n"
        "Sample: layers layers 0-1: Transfer write -> ComputeShader read, CopyTarget -> ShaderReadOnly\n"
        "Sample: layers layers 2-3: ComputeShader write -> ComputeShader read, General -> "
        "ShaderReadOnly\n"
        "Whole: layers: ComputeShader done -> ComputeShader write, Undefined -> General\n"
        "Part: layers layer 3: ComputeShader write -> ComputeShader read, General\n");
}

TEST(Subresources, PartsThatOverlap_WaitWhereTheyDo) {
    GraphMaker graph;
    TextureId chain = graph.Fill("All", graph.Chain("chain", 4, 3));
    graph.Look("Column", chain, Level(1), Access::StorageRead);  // level 1 of all layers
    chain = graph.Fill("Row", chain, Layer(1));                  // all levels of layer 1
    graph.passes.back().keepAlive = true;
    EXPECT_EQ(Waits(graph),
              "All: chain: first use -> ComputeShader write, Undefined -> General\n"
              "Column: chain level 1: ComputeShader write -> ComputeShader read, General\n"
              "Row: chain level 0 layer 1: ComputeShader write -> ComputeShader write, General\n"
              "Row: chain level 1 layer 1: ComputeShader done -> ComputeShader write, General\n"
              "Row: chain levels 2-3 layer 1: ComputeShader write -> ComputeShader write, General\n");
}

TEST(Subresources, LayersDrawnOneByOne_AreSampledTogether) {
    GraphMaker graph;
    TextureId shadows = graph.Chain("shadows", 1, 3);
    for (uint32_t light = 0; light < 3; ++light) {
        graph.AddPass("Light " + std::to_string(light), PassKind::Raster);
        shadows = graph.Use(shadows, Access::ColorWrite, Layer(light));
    }
    graph.Look("Shade", shadows);
    EXPECT_EQ(graph.Order(), "Light 0 Light 1 Light 2 Shade") << "each leaves the layers of the others";
    EXPECT_EQ(Waits(graph),
              "Light 0: shadows layer 0: first use -> ColorOutput write, Undefined -> ColorTarget\n"
              "Light 1: shadows layer 1: first use -> ColorOutput write, Undefined -> ColorTarget\n"
              "Light 2: shadows layer 2: first use -> ColorOutput write, Undefined -> ColorTarget\n"
              "Shade: shadows: ColorOutput write -> ComputeShader read, ColorTarget -> ShaderReadOnly\n");
}

TEST(Subresources, PersistentChain_GoesOnFromTheStateOfEachLevel) {
    GraphMaker first;
    TextureId history = first.Fill("Fill", first.Chain("history", 3, 1, 0, Origin::Persistent));
    first.Look("Look", history, Level(1));
    const Plan before = Compile(first);

    GraphMaker second;
    history = second.Chain("history", 3, 1, 0, Origin::Persistent);
    GraphResource& resource = second.resources.back();
    first.ForEachSubresource(0, [&](uint32_t number, const Subresources& one) {
        if (one.level == 0)
            resource.state = before.states[number];
        else
            resource.otherStates.push_back(before.states[number]);
    });
    second.Look("Sample", history);
    EXPECT_EQ(
        Waits(second),
        "Sample: history level 0: ComputeShader write -> ComputeShader read, General -> ShaderReadOnly\n"
        "Sample: history level 2: ComputeShader write -> ComputeShader read, General -> ShaderReadOnly\n");
}

TEST(Subresources, LaterUseOfALevel_WaitsForItsMemoryToo) {
    GraphMaker graph;
    graph.blockStates = {{.writeStages = kTransfer, .writeAccess = VK_ACCESS_2_TRANSFER_WRITE_BIT}};
    const TextureId large = graph.Fill("Large", graph.Texture("large", 4));
    graph.Look("Look", large, {}, Access::StorageRead);
    TextureId chain = graph.Fill("Draw", graph.Chain("chain", 2, 1, 2), Level(0));
    chain = graph.Step("Halve", chain, Level(0), Level(1));
    graph.Look("Show", chain, {}, Access::StorageRead);
    const TextureId next = graph.Fill("Next", graph.Texture("next", 4));
    graph.Look("End", next, {}, Access::StorageRead);
    EXPECT_EQ(
        Waits(graph),
        "Large: large: memory of the last frame, Transfer write -> ComputeShader write, Undefined -> "
        "General\n"
        "Look: large: ComputeShader write -> ComputeShader read, General\n"
        "Draw: chain level 0: memory of large, ComputeShader done -> ComputeShader write, Undefined -> "
        "General\n"
        "Halve: chain level 0: ComputeShader write -> ComputeShader read, General\n"
        "Halve: chain level 1: memory of large, ComputeShader done -> ComputeShader write, Undefined -> "
        "General\n"
        "Show: chain level 1: ComputeShader write -> ComputeShader read, General\n"
        "Next: next: memory of chain, ComputeShader write -> ComputeShader write, Undefined -> General\n"
        "End: next: ComputeShader write -> ComputeShader read, General\n");
}

// The next occupant waits for a level that nothing has read, beside one whose readers it waits for.
TEST(Subresources, MemoryOfAChain_IsHandedOverWhenAllItsLevelsAreDone) {
    GraphMaker graph;
    TextureId chain = graph.Chain("chain", 2, 1, 2);
    graph.AddPass("Trace", PassKind::RayTracing);
    chain = graph.Use(chain, Access::StorageWrite, Level(1));
    graph.passes.back().keepAlive = true;
    chain = graph.Fill("Draw", chain, Level(0));
    graph.AddPass("Copy", PassKind::Transfer);
    graph.passes.back().keepAlive = true;
    graph.Use(chain, Access::CopyRead, Level(0));
    const TextureId next = graph.Fill("Next", graph.Texture("next", 2));
    graph.Present(next);
    const Plan plan = Compile(graph);
    ASSERT_EQ(plan.passes.back().barriers.count, 1u);
    const Dependency& dependency = plan.barriers[plan.passes.back().barriers.first].dependency;
    EXPECT_EQ(dependency.srcStages & (kTracing | kTransfer), kTracing | kTransfer);
    EXPECT_EQ(dependency.srcAccess & kWrite, kWrite);
}

TEST(Subresources, Import_IsLeftInOneLayout) {
    GraphMaker graph;
    TextureId host = graph.Chain("host", 3, 2, 0, Origin::Imported);
    host = graph.Fill("Fill", host, Level(1));
    graph.Look("Look", host, Subresource(1, 0));
    EXPECT_EQ(graph.Text().substr(graph.Text().find("end\n")),
              "end\n"
              "    waits   host level 0: first use -> AllCommands read, Undefined -> ShaderReadOnly\n"
              "    waits   host level 2: first use -> AllCommands read, Undefined -> ShaderReadOnly\n"
              "    waits   host level 1 layer 1: ComputeShader write -> AllCommands read, General -> "
              "ShaderReadOnly\n"
              "\nresources\n    host  texture 64x64 rgba32f, 3 levels, 2 layers imported    passes 1-2\n");
    const Plan plan = Compile(graph);
    graph.ForEachSubresource(host.resource, [&](uint32_t number, auto&&) {
        EXPECT_EQ(plan.states[number], plan.states[host.resource]);
    });
    EXPECT_EQ(plan.states[host.resource].layout, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

TEST(Subresources, ImportOfSeveralLevels_ComesAndGoesAsAWhole) {
    constexpr uint32_t kOther = 7;
    GraphMaker graph;
    graph.waitStages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    TextureId host = graph.Chain("host", 2, 1, 0, Origin::Imported,
                                 {.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, .queueFamily = kOther});
    host = graph.Step("Halve", host, Level(0), Level(1));
    graph.Export(host, kGeneral, kOther);
    const Plan plan = Compile(graph);
    ASSERT_EQ(plan.acquire.count, 1u);
    EXPECT_EQ(BarrierText(graph, plan.barriers[plan.acquire.first]),
              "host: AllCommands done -> AllCommands read+write, CopyTarget, queue family 7 -> 0")
        << "both levels";
    EXPECT_EQ(Waits(graph, plan),
              "Halve: host level 0: AllCommands done -> ComputeShader read, CopyTarget -> General\n"
              "Halve: host level 1: AllCommands done -> ComputeShader write, Undefined -> General\n"
              "end: host level 0: ComputeShader done -> AllCommands read+write, General\n"
              "end: host level 1: ComputeShader write -> AllCommands read+write, General\n");
    ASSERT_EQ(plan.release.count, 1u);
    EXPECT_EQ(plan.barriers[plan.release.first].part, graph.resources[host.resource].Whole());
    EXPECT_EQ(plan.states[host.resource].queueFamily, kOther);
}

TEST(Subresources, LevelThatNothingReads_IsNotMade) {
    GraphMaker graph;
    TextureId chain = graph.Fill("Draw", graph.Chain("chain", 3), Level(0));
    chain = graph.Step("Halve", chain, Level(0), Level(1));
    chain = graph.Step("Quarter", chain, Level(1), Level(2));
    graph.Look("Look", chain, Level(1));
    EXPECT_EQ(graph.Order(), "Draw Halve Look");
    EXPECT_NE(graph.Text().find("    Quarter (compute): nothing needs chain level 2\n"), std::string::npos)
        << graph.Text();
}

TEST(Subresources, LevelThatIsWrittenAgain_IsNotMadeTwice) {
    GraphMaker graph;
    TextureId chain = graph.Fill("Once", graph.Chain("chain", 2), Level(1));
    chain = graph.Fill("Base", chain, Level(0));
    chain = graph.Fill("Again", chain, Level(1));
    graph.Present(chain);
    EXPECT_EQ(graph.Order(), "Base Again");
}

TEST(Subresources, CulledReaderOfALevel_IsNamed) {
    GraphMaker graph;
    TextureId chain = graph.Fill("Draw", graph.Chain("chain", 3), Level(0));
    chain = graph.Fill("Other", chain, Level(2));
    chain = graph.Step("Halve", chain, Level(0), Level(1));
    const std::string text = graph.Text();
    EXPECT_NE(text.find("    Draw (compute): only culled Halve needs it\n"
                        "    Other (compute): nothing needs chain level 2\n"
                        "    Halve (compute): nothing needs chain level 1\n"),
              std::string::npos)
        << text;
}

TEST(Subresources, PersistentLevelThatIsRead_KeepsItsWriterAlone) {
    GraphMaker graph;
    TextureId history = graph.Chain("history", 2, 1, 0, Origin::Persistent);
    graph.Look("Blend", history, Level(1));
    history = graph.Fill("Keep 0", history, Level(0));
    history = graph.Fill("Keep 1", history, Level(1));
    EXPECT_EQ(graph.Order(), "Blend Keep 1");
}

TEST(Subresources, PlanDot_NamesPartsAndWhatIsKept) {
    GraphMaker graph;
    TextureId chain = graph.Fill("Draw", graph.Chain("chain", 2), Level(0));
    chain = graph.Step("Halve", chain, Level(0), Level(1));
    graph.Present(chain);
    EXPECT_EQ(DescribePlanDot(graph, Compile(graph)), R"(digraph frame {
    rankdir=LR;
    node [fontname="sans-serif"];
    p0 [shape=box, style=solid, label="1 Draw\ncompute"];
    p1 [shape=box, style=solid, label="2 Halve\ncompute"];
    r0v1 [shape=ellipse, style=solid, label="chain v1"];
    p0 -> r0v1 [label="level 0"];
    r0v1 -> p1 [label="level 0"];
    r0v2 [shape=ellipse, style=solid, label="chain v2"];
    p1 -> r0v2 [label="level 1"];
    r0v1 -> r0v2 [style=dotted];
    root0 [shape=plaintext, label="shown"];
    r0v2 -> root0;
}
)");
}

TEST(MergedStates, OfEqualOnes_IsThatState) {
    const ResourceState state{.writeStages = kTracing,
                              .writeAccess = kWrite,
                              .readStages = kCompute,
                              .visibleStages = kCompute,
                              .visibleAccess = VK_ACCESS_2_SHADER_STORAGE_READ_BIT,
                              .layout = kGeneral};
    EXPECT_EQ(Merged(std::array{state, state, state}), state);
    EXPECT_EQ(Merged(std::array{ResourceState{}, ResourceState{}}), ResourceState{});
}

TEST(MergedStates, OfAnUnreadWriteAndAReadOne_WaitForBoth) {
    const ResourceState unread{.writeStages = kTracing, .writeAccess = kWrite};
    const ResourceState read{.writeStages = kCompute,
                             .writeAccess = kWrite,
                             .readStages = kTransfer,
                             .visibleStages = kTransfer,
                             .visibleAccess = VK_ACCESS_2_TRANSFER_READ_BIT};
    for (const auto& states : {std::array{unread, read}, std::array{read, unread}}) {
        ResourceState merged = Merged(states);
        const Dependency next = PlanAccess(
            merged, {.masks = {kCompute, kWrite, kGeneral}, .writes = true, .needsContents = false});
        EXPECT_EQ(next.srcStages, kTracing | kCompute | kTransfer);
        EXPECT_EQ(next.srcAccess, kWrite);
    }
}

TEST(MergedStates, WhatOneSawOfItsWrite_DoesNotCountForTheOther) {
    const ResourceState seen{.writeStages = kTracing,
                             .writeAccess = kWrite,
                             .readStages = kCompute,
                             .visibleStages = kCompute,
                             .visibleAccess = VK_ACCESS_2_SHADER_STORAGE_READ_BIT};
    ResourceState other = seen;
    other.readStages = other.visibleStages = kTransfer;
    const AccessRequest reading{.masks = {kCompute, VK_ACCESS_2_SHADER_STORAGE_READ_BIT}};
    ResourceState merged = Merged(std::array{seen, other});
    EXPECT_EQ(PlanAccess(merged, reading).srcStages, kTracing);
    for (const auto& states : {std::array{seen, ResourceState{}}, std::array{ResourceState{}, seen}}) {
        merged = Merged(states);
        EXPECT_FALSE(PlanAccess(merged, reading).isNeeded) << "the other was never written";
    }
}

TEST(MergedBarriers, OfLayersWithOtherLevels_StayTwo) {
    for (const uint32_t level : {0u, 2u}) {
        std::vector<PlannedBarrier> barriers;
        AddBarrier(barriers, 0, {.resource = 0, .part = Subresource(1, 0), .dependency = {.isNeeded = true}});
        AddBarrier(barriers, 0,
                   {.resource = 0, .part = Subresource(level, 1), .dependency = {.isNeeded = true}});
        MergeLayers(barriers, 0);
        ASSERT_EQ(barriers.size(), 2u);
        EXPECT_EQ(barriers[0].part, Subresource(1, 0));
        EXPECT_EQ(barriers[1].part, Subresource(level, 1));
    }
}

TEST(MergedBarriers, CheckerboardOfLayersAndLevels_LosesNone) {
    std::vector<PlannedBarrier> barriers{{.resource = 9}};  // of another resource
    for (uint32_t layer = 0; layer < 3; ++layer)
        for (uint32_t level = 0; level < 4; ++level) {
            // Two kinds: levels 1 and 2 of layers 0 and 1, and the others; none at level 3 of layer 2.
            const bool isInner = level % 3 != 0 && layer < 2;
            AddBarrier(barriers, 1,
                       {.resource = 0,
                        .part = Subresource(level, layer),
                        .dependency = {.srcStages = isInner ? kTracing : kCompute,
                                       .isNeeded = level != 3 || layer != 2}});
        }
    MergeLayers(barriers, 1);
    std::vector<std::string> parts;
    for (const PlannedBarrier& barrier : barriers) parts.push_back(rhi::PartText(barrier.part, 4, 3));
    EXPECT_EQ(parts,
              (std::vector<std::string>{" level 0 layer 0", " level 0 layers 0-1", " levels 1-2 layers 0-1",
                                        " level 3 layers 0-1", " levels 0-2 layer 2"}));
}

}  // namespace
}  // namespace raygraph::subresource_test
