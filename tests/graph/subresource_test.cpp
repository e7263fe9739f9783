#include <gmock/gmock.h>
#include <algorithm>
#include <array>

#include "renderer/graph/barrier_merge.h"
#include "rhi/transfer.h"
#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"

// Textures of several levels and layers, without a device: what is culled, and the
// barriers of each part, as text.
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
    const auto range = [&](std::string_view before, const BarrierRange& barriers) {
        for (uint32_t b = barriers.first; b < barriers.first + barriers.count; ++b)
            text.append(before).append(": " + BarrierText(graph, plan.barriers[b]) + '\n');
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
            second.otherStates[one.level - 1] = before.states[number];
    });
    resource.hasOtherStates = true;
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

// Textures of several levels and layers on a device: mip chains made by passes, layers drawn one by one, cube
// maps, histories of levels, imports; and what is refused when a pass declares it.
namespace raygraph::subresource_frame_test {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Texels;

// The mean of up to 2x2 texels of the finer level; sums of few small whole numbers are exact.
constexpr std::string_view kHalveImage = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform readonly image2D finer;
layout(binding = 1, r32f) uniform writeonly image2D coarser;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(coarser)))) return;
    ivec2 last = imageSize(finer) - 1;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) sum += imageLoad(finer, min(2 * texel + ivec2(i & 1, i >> 1), last));
    imageStore(coarser, texel, 0.25 * sum);
})";
// Halves through a sampler: the level that is read has another layout.
constexpr std::string_view kHalveSampled = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D finer;
layout(binding = 1, r32f) uniform writeonly image2D coarser;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(coarser)))) return;
    ivec2 last = textureSize(finer, 0) - 1;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) sum += texelFetch(finer, min(2 * texel + ivec2(i & 1, i >> 1), last), 0);
    imageStore(coarser, texel, 0.25 * sum);
})";
// The first texel of every level of a view.
constexpr std::string_view kFirstOfLevels = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D chain;
layout(binding = 1, r32f) uniform writeonly image2D firsts;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (texel.y == 0 && texel.x < min(textureQueryLevels(chain), imageSize(firsts).x))
        imageStore(firsts, texel, texelFetch(chain, ivec2(0), texel.x));
})";
constexpr std::string_view kAddLayers = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2DArray layers;
layout(binding = 1, r32f) uniform writeonly image2D sum;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(sum)))) return;
    vec4 all = vec4(0.0);
    for (int layer = 0; layer < textureSize(layers, 0).z; ++layer)
        all = 10.0 * all + texelFetch(layers, ivec3(texel, layer), 0);
    imageStore(sum, texel, all);
})";
constexpr std::string_view kNumberLayers = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform writeonly image2DArray layers;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(layers).xy))) return;
    for (int layer = 0; layer < imageSize(layers).z; ++layer)
        imageStore(layers, ivec3(texel, layer), vec4(float(layer + 1)));
})";
constexpr std::string_view kLookAround = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform samplerCube sky;
layout(binding = 1, r32f) uniform writeonly image2D seen;
void main() {
    const vec3 axes[3] = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (texel.y != 0 || texel.x >= 6) return;
    imageStore(seen, texel, textureLod(sky, (1.0 - 2.0 * float(texel.x & 1)) * axes[texel.x / 2], 0.0));
})";

class SubresourceFrames : public GraphTest {
  protected:
    SubresourceFrames() { AddShaders(m_renderer); }

    static void AddShaders(Renderer& renderer) {
        AddTestShaders(renderer);
        for (const auto& [name, text] : {std::pair("test/halve_image.comp", kHalveImage),
                                         {"test/halve_sampled.comp", kHalveSampled},
                                         {"test/first_of_levels.comp", kFirstOfLevels},
                                         {"test/add_layers.comp", kAddLayers},
                                         {"test/number_layers.comp", kNumberLayers},
                                         {"test/look_around.comp", kLookAround}})
            renderer.AddShader(name, CompileText(name, text));
        renderer.AddShader("test/all.vert", CompileText("test/all.vert", R"(
void main() { gl_Position = vec4(gl_VertexIndex == 1 ? 3 : -1, gl_VertexIndex == 2 ? 3 : -1, 0.25, 1); })"));
        renderer.AddShader("test/value.frag", CompileText("test/value.frag", R"(
layout(location = 0) out vec4 color;
layout(push_constant, std430) uniform Constants { float value; } constants;
void main() { color = vec4(constants.value); })"));
    }

    // Level by level, each from the one before.
    static TextureId MakeMips(Renderer& renderer, TextureId chain, bool isSampled) {
        const GraphTextureDesc desc = renderer.Desc(chain);
        for (uint32_t level = 1; level < desc.levels; ++level) {
            const Extent2D extent = rhi::MipExtent(desc.extent, level);
            renderer.AddPass(
                "Level " + std::to_string(level), PassKind::Compute,
                [&](PassBuilder& pass) {
                    pass.Compute(isSampled ? "test/halve_sampled.comp" : "test/halve_image.comp");
                    if (isSampled)
                        pass.Reads("finer", chain, Level(level - 1), rhi::SamplerDesc{});
                    else
                        pass.Reads("finer", chain, Level(level - 1));
                    chain = pass.Writes("coarser", chain, Level(level));
                },
                [extent](CommandList& commands) { commands.DispatchOver(extent); });
        }
        return chain;
    }
    static TextureId FillLevel(Renderer& renderer, TextureId chain, const Subresources& part, float value) {
        const Extent2D extent = rhi::MipExtent(renderer.Desc(chain).extent, part.level);
        renderer.AddPass(
            "Fill", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/fill.comp");
                chain = pass.Writes("target", chain, part);
                pass.Constants(value);
            },
            [extent](CommandList& commands) { commands.DispatchOver(extent); });
        return chain;
    }
    // A pass of one shader that reads a texture through a sampler and writes a new one.
    TextureId Through(const char* shader, const char* source, TextureId texture, const Subresources& part,
                      const char* target, Extent2D extent) {
        TextureId made = m_renderer.CreateTexture(target, {.extent = extent, .format = Format::R32Float});
        m_renderer.AddPass(
            shader, PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute(shader);
                pass.Reads(source, texture, part, rhi::SamplerDesc{.magFilter = rhi::Filter::Nearest});
                made = pass.Writes(target, made);
            },
            [extent](CommandList& commands) { commands.DispatchOver(extent); });
        return made;
    }
    static std::vector<float> Halved(const std::vector<float>& finer, Extent2D from, Extent2D to) {
        std::vector<float> coarser;
        for (uint32_t y = 0; y < to.height; ++y)
            for (uint32_t x = 0; x < to.width; ++x) {
                float sum = 0.0f;
                for (uint32_t i = 0; i < 4; ++i)
                    sum += finer[std::min(2 * y + (i >> 1), from.height - 1) * from.width +
                                 std::min(2 * x + (i & 1), from.width - 1)];
                coarser.push_back(0.25f * sum);
            }
        return coarser;
    }
    static float First(const Readback& readback) { return Read(readback).At(0, 0)[0]; }
};

TEST_F(SubresourceFrames, MipChain_IsTheBoxFilterOfEachLevelExactly) {
    for (const bool isSampled : {false, true})
        for (const Extent2D extent : {Extent2D{16, 16}, Extent2D{37, 10}}) {
            testing::PassHarness harness(Device());
            AddShaders(harness.Graph());
            const std::vector<Texels> levels = harness.RunAll([&](testing::PassHarness& h) {
                const TextureId chain = h.Graph().CreateTexture(
                    "chain",
                    {.extent = extent, .format = Format::R32Float, .levels = rhi::FullMipCount(extent)});
                return MakeMips(h.Graph(), FillLevel(h.Graph(), chain, Level(0), 7.0f), isSampled);
            });
            ASSERT_EQ(levels.size(), rhi::FullMipCount(extent));
            EXPECT_TRUE(IsRamp(levels[0], 7.0f));
            for (uint32_t level = 1; level < levels.size(); ++level) {
                EXPECT_EQ(levels[level].extent, rhi::MipExtent(extent, level));
                EXPECT_EQ(levels[level].values,
                          Halved(levels[level - 1].values, levels[level - 1].extent, levels[level].extent))
                    << "level " << level;
            }
            EXPECT_EQ(levels.back().extent, (Extent2D{1, 1}));
        }
}

TEST_F(SubresourceFrames, WholeChain_IsSampledLevelByLevel_AndARangeFromItsFirst) {
    m_renderer.BeginFrame();
    TextureId chain =
        m_renderer.CreateTexture("chain", {.extent = {8, 8}, .format = Format::R32Float, .levels = 4});
    for (uint32_t level = 0; level < 4; ++level)
        chain = FillLevel(m_renderer, chain, Level(level), static_cast<float>(10 + level));
    const Readback all =
        m_renderer.ReadBack(Through("test/first_of_levels.comp", "chain", chain, {}, "firsts", {4, 1}));
    const Readback two = m_renderer.ReadBack(
        Through("test/first_of_levels.comp", "chain", chain, rhi::Levels(1, 2), "firsts", {2, 1}));
    m_renderer.Execute();
    EXPECT_THAT(Read(all).values, ElementsAre(10, 11, 12, 13));
    EXPECT_THAT(Read(two).values, ElementsAre(11, 12));
}

TEST_F(SubresourceFrames, LayersDrawnOneByOne_AreReadTogetherAndApart) {
    m_renderer.BeginFrame();
    TextureId layers = m_renderer.CreateTexture(
        "layers", {.extent = {8, 4}, .format = Format::R32Float, .levels = 2, .layers = 3});
    TextureId depths =
        m_renderer.CreateTexture("depths", {.extent = {4, 2}, .format = Format::D32Float, .layers = 3});
    // Level 1 is as large as the depths.
    for (uint32_t layer = 0; layer < 3; ++layer)
        m_renderer.AddPass(
            "Draw", PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("test/all.vert").Fragment("test/value.frag");
                pass.Constants(static_cast<float>(layer + 1));
                layers = pass.ColorTarget(0, layers, Subresource(1, layer));
                depths = pass.DepthTarget(depths, Layer(layer), {.value = layer == 1 ? 0.125f : 1.0f});
            },
            [](CommandList& commands) { commands.Draw(3); });
    const Readback sum =
        m_renderer.ReadBack(Through("test/add_layers.comp", "layers", layers, Level(1), "sum", {4, 2}));
    std::vector<Readback> apart, depthOf;
    for (uint32_t layer = 0; layer < 3; ++layer) {
        apart.push_back(m_renderer.ReadBack(layers, 1, layer));
        depthOf.push_back(m_renderer.ReadBack(depths, 0, layer));
    }
    m_renderer.Execute();
    // The depth of layer 1 is nearer than what is drawn there.
    EXPECT_THAT(Read(sum).values, Each(103));
    const std::array drawn{1.0f, 0.0f, 3.0f}, depth{0.25f, 0.125f, 0.25f};
    for (size_t layer = 0; layer < 3; ++layer) {
        EXPECT_EQ(Read(apart[layer]).extent, (Extent2D{4, 2}));
        EXPECT_THAT(Read(apart[layer]).values, Each(drawn[layer])) << layer;
        EXPECT_THAT(Read(depthOf[layer]).values, Each(depth[layer])) << layer;
    }
}

TEST_F(SubresourceFrames, CubeMap_HasItsFacesAroundIt) {
    m_renderer.BeginFrame();
    TextureId sky =
        m_renderer.CreateTexture("sky", {.extent = {4, 4}, .format = Format::R32Float, .layers = 6});
    m_renderer.AddPass(
        "Number", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("test/number_layers.comp");
            sky = pass.Writes("layers", sky);
        },
        [](CommandList& commands) {
            commands.DispatchOver({4, 4});
        });
    const Readback seen =
        m_renderer.ReadBack(Through("test/look_around.comp", "sky", sky, {}, "seen", {6, 1}));
    m_renderer.Execute();
    EXPECT_THAT(Read(seen).values, ElementsAre(1, 2, 3, 4, 5, 6)) << "+x -x +y -y +z -z";
}

// Each instance is drawn to a layer of its own, all by one draw. The others keep what they had, and depth, of
// which the last instance finds a nearer one, is tested layer by layer.
TEST_F(SubresourceFrames, LayeredTargets_AreDrawnByOneDraw) {
    if (!Device().Info().optional.layeredTargets) GTEST_SKIP() << "the device has no layered targets";
    m_renderer.AddShader("test/layers.vert", CompileText("test/layers.vert", R"(
#extension GL_ARB_shader_viewport_layer_array : require
layout(location = 0) out float value;
void main() {
    const vec2 corners[3] = vec2[](vec2(-1.0, -1.0), vec2(3.0, -1.0), vec2(-1.0, 3.0));
    gl_Layer = gl_InstanceIndex % 3;
    value = 10.0 + float(gl_InstanceIndex);
    gl_Position = vec4(corners[gl_VertexIndex], gl_InstanceIndex == 3 ? 0.75 : 0.5, 1.0);
})"));
    m_renderer.AddShader("test/value.frag", CompileText("test/value.frag", R"(
layout(location = 0) in float value;
layout(location = 0) out float color;
void main() { color = value; })"));
    m_renderer.BeginFrame();
    TextureId layers = m_renderer.CreateTexture(
        "layers", {.extent = {8, 8}, .format = Format::R32Float, .levels = 2, .layers = 5});
    TextureId depth =
        m_renderer.CreateTexture("depth", {.extent = {4, 4}, .format = Format::D32Float, .layers = 3});
    m_renderer.AddPass(
        "Clear", PassKind::Transfer, [&](PassBuilder& pass) { layers = pass.CopiesTo(layers); },
        [layers](CommandList& commands, const PassResources& resources) {
            commands.Clear(resources.Texture(layers), {1.0f, 0.0f, 0.0f, 0.0f});
        });
    m_renderer.AddPass(
        "Draw", PassKind::Raster,
        [&](PassBuilder& pass) {
            pass.Vertex("test/layers.vert").Fragment("test/value.frag");
            layers = pass.ColorTarget(0, layers, {.level = 1, .levelCount = 1, .layer = 1, .layerCount = 3},
                                      {.value = {2.0f}});
            depth = pass.DepthTarget(depth, Layers(0, 3));
        },
        [](CommandList& commands) { commands.Draw(3, 4); });
    std::vector<Readback> all;
    for (uint32_t layer = 0; layer < 5; ++layer) all.push_back(m_renderer.ReadBack(layers, 1, layer));
    const Readback other = m_renderer.ReadBack(layers, 0, 2);
    m_renderer.Execute();
    const float expected[] = {1.0f, 10.0f, 11.0f, 12.0f, 1.0f};
    for (uint32_t layer = 0; layer < 5; ++layer)
        EXPECT_THAT(Read(all[layer]).values, Each(expected[layer])) << layer;
    EXPECT_THAT(Read(other).values, Each(1.0f));
}

TEST_F(SubresourceFrames, TransfersOfParts_ClearAndCopyThemAlone) {
    m_renderer.BeginFrame();
    TextureId chain = m_renderer.CreateTexture(
        "chain", {.extent = {8, 8}, .format = Format::R32Float, .levels = 2, .layers = 2});
    m_renderer.AddPass(
        "Clear", PassKind::Transfer, [&](PassBuilder& pass) { chain = pass.CopiesTo(chain); },
        [chain](CommandList& commands, const PassResources& resources) {
            commands.Clear(resources.Texture(chain), {1.0f, 0.0f, 0.0f, 0.0f});
        });
    m_renderer.AddPass(
        "Clear one", PassKind::Transfer,
        [&](PassBuilder& pass) { chain = pass.CopiesTo(chain, Subresource(1, 0)); },
        [chain](CommandList& commands, const PassResources& resources) {
            commands.Clear(resources.Texture(chain), {2.0f, 0.0f, 0.0f, 0.0f}, Subresource(1, 0));
        });
    // From one layer to the other of the same texture, in one pass.
    m_renderer.AddPass(
        "Copy", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(chain, Subresource(1, 0));
            chain = pass.CopiesTo(chain, Subresource(1, 1));
        },
        [chain](CommandList& commands, const PassResources& resources) {
            const rhi::Texture& texture = resources.Texture(chain);
            commands.CopyTexture(texture, {.level = 1, .layer = 0}, texture, {.level = 1, .layer = 1});
        });
    std::vector<Readback> all;
    for (uint32_t layer = 0; layer < 2; ++layer)
        for (uint32_t level = 0; level < 2; ++level) all.push_back(m_renderer.ReadBack(chain, level, layer));
    m_renderer.Execute();
    EXPECT_THAT(Read(all[0]).values, Each(1));
    EXPECT_THAT(Read(all[1]).values, Each(2));
    EXPECT_THAT(Read(all[2]).values, Each(1));
    EXPECT_THAT(Read(all[3]).values, Each(2));
}

TEST_F(SubresourceFrames, PersistentLevels_AreWrittenAndReadInDifferentFrames) {
    const GraphTextureDesc desc{.extent = {8, 8}, .format = Format::R32Float, .levels = 3};
    std::vector<float> firsts;
    for (uint32_t frame = 0; frame < 4; ++frame) {
        m_renderer.BeginFrame();
        TextureId chain = m_renderer.Persist("chain", desc);
        for (uint32_t level = 0; level < 3; ++level)
            EXPECT_EQ(m_renderer.IsFresh(chain, Level(level)), level >= frame) << frame << ' ' << level;
        EXPECT_EQ(m_renderer.IsFresh(chain), frame < 3);
        // Frame 0 fills level 0, frame 1 makes level 1 of it, frame 2 level 2; frame 3 only looks.
        const uint32_t level = std::min(frame, 2u);
        if (frame == 0) {
            chain = FillLevel(m_renderer, chain, Level(0), 1.0f);
        } else if (frame < 3) {
            const Extent2D extent = rhi::MipExtent(desc.extent, level);
            m_renderer.AddPass(
                "Next level", PassKind::Compute,
                [&](PassBuilder& pass) {
                    pass.Compute("test/halve_sampled.comp");
                    pass.Reads("finer", chain, Level(level - 1), rhi::SamplerDesc{});
                    chain = pass.Writes("coarser", chain, Level(level));
                },
                [extent](CommandList& commands) { commands.DispatchOver(extent); });
        }
        if (frame < 3) {
            EXPECT_FALSE(m_renderer.IsFresh(chain, Level(level))) << "this frame writes it";
        }
        const Readback readback = m_renderer.ReadBack(chain, level);
        m_renderer.Execute();
        firsts.push_back(First(readback));
    }
    // 1 + x + 100 y over 1, 2x2, 4x4 texels
    EXPECT_THAT(firsts, ElementsAre(1.0f, 51.5f, 152.5f, 152.5f));
}

TEST_F(SubresourceFrames, ImportOfALevel_LeavesAllInOneLayoutForItsOwner) {
    const rhi::Texture host = Device().CreateTexture(
        {.name = "host",
         .extent = {8, 8},
         .format = Format::R32Float,
         .usage = rhi::TextureUsage::Storage | rhi::TextureUsage::Sampled | rhi::TextureUsage::CopySource,
         .mipLevels = 3});
    ResourceState state;
    for (int frame = 0; frame < 3; ++frame) {
        m_renderer.BeginFrame();
        const TextureId chain = m_renderer.Import("host", host, state);
        EXPECT_EQ(m_renderer.Desc(chain).levels, 3u);
        const TextureId made = MakeMips(
            m_renderer, FillLevel(m_renderer, chain, Level(0), static_cast<float>(frame)), frame != 1);
        const Readback last = m_renderer.ReadBack(made, 2);
        m_renderer.Execute();
        EXPECT_EQ(First(last), 151.5f + static_cast<float>(frame));
        for (uint32_t level = 0; level < 3; ++level)
            EXPECT_EQ(testing::As<float>(rhi::ReadTexture(Device(), host, state.layout, level)).size(),
                      size_t{8u >> level} * (8u >> level));
    }
}

// Transients of other shapes take the memory by turns; the plan shares it, and the texels are right.
TEST_F(SubresourceFrames, ChainsThatShareMemory_HoldTheirOwn) {
    for (int frame = 0; frame < 3; ++frame) {
        m_renderer.BeginFrame();
        std::vector<Readback> lasts;
        for (uint32_t i = 0; i < 3; ++i) {
            TextureId chain = m_renderer.CreateTexture(
                "chain " + std::to_string(i),
                {.extent = {16, 16}, .format = Format::R32Float, .levels = 3 + i % 2});
            chain =
                MakeMips(m_renderer, FillLevel(m_renderer, chain, Level(0), static_cast<float>(i)), i == 1);
            lasts.push_back(m_renderer.ReadBack(chain, 2));
        }
        m_renderer.Execute();
        EXPECT_THAT(m_renderer.DescribePlan(), HasSubstr("chain 1 level 0: memory of chain 0, "));
        for (size_t i = 0; i < 3; ++i) EXPECT_EQ(First(lasts[i]), 151.5f + static_cast<float>(i));
    }
}

TEST_F(SubresourceFrames, Harness_FillsAndReadsAllLevelsOfAllLayers) {
    testing::PassHarness harness(Device());
    const GraphTextureDesc desc{.extent = {2, 1}, .format = Format::R8Unorm, .levels = 2, .layers = 2};
    const std::vector<float> values{0, 1, 1, 1, 0, 0};
    const std::vector<Texels> all =
        harness.RunAll([&](testing::PassHarness& h) { return h.Texture("pairs", desc, values); });
    ASSERT_EQ(all.size(), 4u);
    EXPECT_THAT(all[0].values, ElementsAre(0, 1));
    EXPECT_THAT(all[1].values, ElementsAre(1));
    EXPECT_THAT(all[2].values, ElementsAre(1, 0));
    EXPECT_THAT(all[3].values, ElementsAre(0));
    EXPECT_THAT(testing::ErrorTextOf([&] {
                    harness.RunAll([&](testing::PassHarness& h) {
                        return h.Texture("pairs", desc, std::vector<float>(7));
                    });
                }),
                HasSubstr("2 values for 1x1 r8, which has 1"));
}

TEST_F(SubresourceFrames, LimitsOfATexture_AreNamed) {
    m_renderer.BeginFrame();
    const auto text = [&](const GraphTextureDesc& desc) {
        return testing::ErrorTextOf([&] { m_renderer.CreateTexture("chain", desc); });
    };
    EXPECT_EQ(text({.extent = {20, 4}, .levels = 6}),
              R"(texture "chain": 6 levels; 20x4 texels have 1 to 5)");
    EXPECT_EQ(text({.extent = {20, 4}, .levels = 0}),
              R"(texture "chain": 0 levels; 20x4 texels have 1 to 5)");
    const uint32_t most = Device().Info().maxTextureLayers;
    EXPECT_EQ(text({.extent = {20, 4}, .layers = most + 1}),
              R"(texture "chain": )" + std::to_string(most + 1) + " layers; the device " +
                  Device().Info().name + " has 1 to " + std::to_string(most));
    EXPECT_THAT(testing::ErrorTextOf([&] {
                    m_renderer.Persist("kept", {.extent = {1, 1}, .levels = 2});
                }),
                HasSubstr(R"(texture "kept": 2 levels; 1x1 texels have 1 to 1)"));
    const TextureId chain = m_renderer.CreateTexture("chain", {.extent = {4, 4}, .levels = 2});
    EXPECT_EQ(testing::ErrorTextOf([&] { m_renderer.ReadBack(chain, 2); }),
              R"(ReadBack reads "chain": level 2, there are 2)");
    EXPECT_EQ(testing::ErrorTextOf([&] { m_renderer.ReadBack(chain, 0, 1); }),
              R"(ReadBack reads "chain": layer 1, there is 1)");
    EXPECT_EQ(testing::ErrorTextOf([&] {
                  std::ignore = m_renderer.IsFresh(m_renderer.Persist("kept", {.extent = {4, 4}}), Level(1));
              }),
              R"(IsFresh asks about "kept": level 1, there is 1)");
}

}  // namespace
}  // namespace raygraph::subresource_frame_test
