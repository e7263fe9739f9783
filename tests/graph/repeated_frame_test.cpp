// Frames that are declared like the one before, whose plan is taken over, and that allocate nothing.
#include <array>
#include <functional>
#include <memory>
#include <tuple>

#include "tests/graph/graph_test.h"
#include "tests/graph/oracle.h"
#include "tests/graph/random_frames.h"
#include "tests/support/failing_memory.h"

namespace raygraph::repeated_frame_test {
namespace {

// --- Which frames have the same plan ---

TEST(SamePlan, RandomFramesDeclaredAlikeHaveIt) {
    for (uint64_t seed = 0; seed < 200; ++seed) {
        oracle::Oracle firstOracle, secondOracle;
        RandomFrames first(seed, firstOracle), second(seed, secondOracle);
        const FrameGraph& graph = first.Declare();
        const FrameGraph& again = second.Declare();
        ASSERT_TRUE(graph.HasSamePlanAs(again)) << seed;
        EXPECT_EQ(DescribePlan(graph, Compile(graph)), DescribePlan(again, Compile(again))) << seed;
    }
}

// Memory that Compile has used for other frames changes nothing.
TEST(SamePlan, MemoryOfOtherFramesDoesNotChangeThePlan) {
    Plan plan;
    CompileMemory memory;
    for (uint64_t seed = 0; seed < 100; ++seed) {
        oracle::Oracle oracle;
        RandomFrames frames(seed, oracle);
        for (int frame = 0; frame < 3; ++frame) {
            const FrameGraph& graph = frames.Declare();
            Compile(graph, plan, memory);
            const Plan alone = Compile(graph);
            ASSERT_EQ(DescribePlan(graph, plan), DescribePlan(graph, alone)) << seed;
            ASSERT_EQ(plan.states, alone.states) << seed;
            ASSERT_EQ(plan.blockStates, alone.blockStates) << seed;
            ASSERT_EQ(plan.bytesWithoutAliasing, alone.bytesWithoutAliasing) << seed;
            frames.Commit(plan, oracle);
        }
    }
}

FrameGraph MixedFrame() {
    GraphMaker graph;
    const TextureId history = graph.Persistent("history");
    const TextureId chain = graph.Chain("chain", 3, 2, 1, Origin::Persistent);
    const TextureId host = graph.Imported<ResourceKind::Texture>("host");
    TextureId result = graph.Texture("result", 2);
    result = graph.Pass("Blend", {history}, result);
    graph.Step("Reduce", chain, Level(0), Level(1));
    graph.Export(graph.Pass("Show", {result}, host), VK_IMAGE_LAYOUT_GENERAL);
    graph.blockStates.resize(1);
    return graph;
}

TEST(SamePlan, EveryDifferenceCounts) {
    struct Difference {
        const char* what;
        std::function<void(FrameGraph&)> make;
    };
    const Difference differences[] = {
        {"family", [](FrameGraph& g) { g.queueFamily = 7; }},
        {"compute family", [](FrameGraph& g) { g.computeFamily = 7; }},
        {"queue of a pass", [](FrameGraph& g) { g.passes[0].queue = rhi::QueueKind::Compute; }},
        {"sharing", [](FrameGraph& g) { g.resources[0].isShared = false; }},
        {"wait stages", [](FrameGraph& g) { g.waitStages = VK_PIPELINE_STAGE_2_COPY_BIT; }},
        {"name", [](FrameGraph& g) { g.resources[0].name = "other"; }},
        {"origin", [](FrameGraph& g) { g.resources[3].origin = Origin::Persistent; }},
        {"persistence", [](FrameGraph& g) { g.resources[0].persistence = Persistence::Always; }},
        {"extent", [](FrameGraph& g) { g.resources[3].extent.width = 65; }},
        {"format", [](FrameGraph& g) { g.resources[3].format = Format::R32Float; }},
        {"layers", [](FrameGraph& g) { g.resources[1].layers = 3; }},
        {"bytes", [](FrameGraph& g) { g.resources[0].bytes = 3; }},
        {"memory", [](FrameGraph& g) { g.resources[3].memory.size += 1; }},
        {"state", [](FrameGraph& g) { g.resources[2].state.layout = VK_IMAGE_LAYOUT_GENERAL; }},
        {"access", [](FrameGraph& g) { g.resources[0].state.readStages = VK_PIPELINE_STAGE_2_COPY_BIT; }},
        {"state of a level", [](FrameGraph& g) { g.otherStates[4].layout = VK_IMAGE_LAYOUT_GENERAL; }},
        {"states of levels", [](FrameGraph& g) { g.resources[1].hasOtherStates = true; }},
        {"state of a block", [](FrameGraph& g) { g.blockStates[0].writeStages = 1; }},
        {"pass", [](FrameGraph& g) { g.AddPass("More", PassKind::Compute); }},
        {"name of a pass", [](FrameGraph& g) { g.passes[0].name = "Other"; }},
        {"kind of a pass", [](FrameGraph& g) { g.passes[0].kind = PassKind::RayTracing; }},
        {"kept", [](FrameGraph& g) { g.passes[1].keepAlive = true; }},
        {"waiting", [](FrameGraph& g) { g.passes[1].waits = true; }},
        {"use", [](FrameGraph& g) { g.uses[0].resource = 1; }},
        {"version", [](FrameGraph& g) { g.uses[0].versionIn = 2; }},
        {"kind of a use", [](FrameGraph& g) { g.uses[0].access = Access::Sampled; }},
        {"part", [](FrameGraph& g) { g.uses[2].part.levelCount = 2; }},
        {"root", [](FrameGraph& g) { g.Present(g.IdOf<ResourceKind::Texture>(0)); }},
        {"layout of a root",
         [](FrameGraph& g) { g.roots[0].layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL; }},
        {"family of a root", [](FrameGraph& g) { g.roots[0].queueFamily = 7; }},
    };
    const FrameGraph graph = MixedFrame();
    EXPECT_TRUE(graph.HasSamePlanAs(MixedFrame()));
    for (const Difference& difference : differences) {
        FrameGraph other = graph;
        difference.make(other);
        EXPECT_FALSE(graph.HasSamePlanAs(other)) << difference.what;
    }
}

TEST(SamePlan, NamesOfACopyOutliveTheOriginal) {
    GraphMaker graph;
    graph.Texture("a name that is longer than what a string holds without memory");
    const FrameGraph copy = graph;
    graph.Begin(2);
    graph.Texture("another name, which takes the place of the first one in memory");
    EXPECT_EQ(copy.resources[0].name, "a name that is longer than what a string holds without memory");
}

// --- Repeated frames on a device ---

using RepeatedFrame = GraphTest;
constexpr Extent2D kExtent{13, 7};

TEST_F(RepeatedFrame, ChangesOfSizeAndBack_ShowTheSamePixels) {
    // Blocks of memory grow with the second kind of frame, and objects in them are made again.
    constexpr uint32_t kSizes[] = {16, 16, 16, 300, 300, 16, 16, 300, 16, 16, 16};
    for (const uint32_t size : kSizes) {
        m_renderer.BeginFrame();
        const TextureId a = Fill(m_renderer, "a", {size, size}, static_cast<float>(size));
        const TextureId b = Scale(m_renderer, "b", a, 2.0f);
        const Readback readback = m_renderer.ReadBack(Scale(m_renderer, "c", b, 2.0f));
        m_renderer.Execute();
        EXPECT_TRUE(IsRamp(Read(readback), static_cast<float>(size), 4.0f)) << size;
    }
}

TEST_F(RepeatedFrame, PersistentTextureSumsUpOverFrames) {
    for (int frame = 1; frame <= 6; ++frame) {
        m_renderer.BeginFrame();
        const TextureId sum = AddTo(m_renderer, "sum", Fill(m_renderer, "one", kExtent, 3.0f));
        const Readback readback = m_renderer.ReadBack(sum);
        m_renderer.Execute();
        EXPECT_TRUE(IsRamp(Read(readback), 3.0f, static_cast<float>(frame))) << frame;
    }
}

// The host has used the image between two frames that are declared alike.
TEST_F(RepeatedFrame, StateOfAnImportIsThatOfThisFrame) {
    const rhi::Texture image = Device().CreateTexture(
        {.name = "host",
         .extent = kExtent,
         .format = Format::R32Float,
         .usage = rhi::TextureUsage::Storage | rhi::TextureUsage::Sampled | rhi::TextureUsage::CopySource});
    ResourceState state;
    std::string plans[4];
    for (std::string& plan : plans) {
        const bool isHosts = &plan == &plans[3];
        if (isHosts) state = {.layout = VK_IMAGE_LAYOUT_UNDEFINED};
        m_renderer.BeginFrame();
        const TextureId shown = FillInto(m_renderer, "Fill", m_renderer.Import("host", image, state), 1.0f);
        m_renderer.Export(shown, VK_IMAGE_LAYOUT_GENERAL);
        m_renderer.Execute();
        plan = m_renderer.DescribePlan();
        EXPECT_EQ(state.layout, VK_IMAGE_LAYOUT_GENERAL);
    }
    EXPECT_EQ(plans[1], plans[2]);
    EXPECT_EQ(plans[3], plans[0]);
    EXPECT_NE(plans[3], plans[2]);
    Device().WaitIdle();
}

// The plan of the first frame found memory that nobody had used.
TEST_F(RepeatedFrame, TransientWaitsForTheLastFrameInItsMemory) {
    for (int frame = 0; frame < 4; ++frame) {
        m_renderer.BeginFrame();
        m_renderer.Present(Fill(m_renderer, "a", kExtent, 1.0f));
        m_renderer.Execute();
        const std::string plan = m_renderer.DescribePlan();
        EXPECT_EQ(plan.find("memory of the last frame") != std::string::npos, frame > 0) << plan;
    }
}

// A declaration after Compile makes the plan of this frame another one; that of the last frame stays readable.
TEST_F(RepeatedFrame, PassAfterCompile_IsPlannedToo) {
    const auto declare = [&] {
        m_renderer.BeginFrame();
        return Fill(m_renderer, "a", kExtent, 1.0f);
    };
    std::string plan;
    for (int frame = 0; frame < 3; ++frame) {
        m_renderer.Present(declare());
        m_renderer.Execute();
        plan = m_renderer.DescribePlan();
    }
    const TextureId a = declare();
    m_renderer.Present(a);
    m_renderer.Compile();
    EXPECT_EQ(m_renderer.DescribePlan(), plan);
    const Readback readback = m_renderer.ReadBack(Scale(m_renderer, "b", a, 2.0f));
    EXPECT_EQ(m_renderer.DescribePlan(), plan) << "that of the last frame, until this one is compiled again";
    m_renderer.Execute();
    EXPECT_NE(m_renderer.DescribePlan(), plan);
    EXPECT_TRUE(IsRamp(Read(readback), 1.0f, 2.0f));
}

TEST_F(RepeatedFrame, DroppedFramesBetween_AreNoHarm) {
    for (int frame = 0; frame < 6; ++frame) {
        m_renderer.BeginFrame();
        const TextureId scaled =
            Scale(m_renderer, "b", Fill(m_renderer, "a", kExtent, static_cast<float>(frame)), 2.0f);
        const Readback readback = m_renderer.ReadBack(scaled);
        if (frame % 2 == 1) m_renderer.Compile();
        if (frame % 3 == 1) {
            m_renderer.DropFrame();
            continue;
        }
        m_renderer.Execute();
        EXPECT_TRUE(IsRamp(Read(readback), static_cast<float>(frame), 2.0f)) << frame;
    }
}

// Other shaders and bindings at the same place of the frame.
TEST_F(RepeatedFrame, PassesThatTakeTurns_AreEachTheirOwn) {
    for (int frame = 0; frame < 6; ++frame) {
        m_renderer.BeginFrame();
        const TextureId a = Fill(m_renderer, "a", kExtent, 5.0f);
        const TextureId b =
            frame % 2 == 0 ? Scale(m_renderer, "b", a, 3.0f) : Fill(m_renderer, "b", kExtent, 9.0f);
        const Readback readback = m_renderer.ReadBack(b);
        m_renderer.Execute();
        EXPECT_TRUE(frame % 2 == 0 ? IsRamp(Read(readback), 5.0f, 3.0f) : IsRamp(Read(readback), 9.0f))
            << frame;
        if (frame == 3) m_renderer.ReleasePipelines(0.0);
    }
}

// The body of a pass lives in the frame's memory, and is destroyed with the frame.
TEST_F(RepeatedFrame, CapturesEndWithTheirFrame) {
    const auto watched = std::make_shared<int>(0);
    for (int frame = 0; frame < 3; ++frame) {
        m_renderer.BeginFrame();
        TextureId target = m_renderer.CreateTexture("a", {.extent = kExtent, .format = Format::R32Float});
        m_renderer.AddPass(
            "Clear", PassKind::Transfer, [&](PassBuilder& pass) { target = pass.CopiesTo(target); },
            [watched, target](CommandList& commands, const PassResources& resources) {
                commands.Clear(resources.Texture(target), {0.0f, 0.0f, 0.0f, 0.0f});
                ++*watched;
            });
        m_renderer.Present(target);
        EXPECT_EQ(watched.use_count(), 2);
        if (frame == 1)
            m_renderer.DropFrame();
        else
            m_renderer.Execute();
        EXPECT_EQ(watched.use_count(), 1);
    }
    EXPECT_EQ(*watched, 2);
    Device().WaitIdle();
}

// --- Allocations ---

TEST_F(RepeatedFrame, DeclaringAndCompilingItAllocatesNothing) {
    Renderer renderer(Device(), {.keptTimings = 0});
    AddTestShaders(renderer);
    const std::string names[] = {"a texture with a name that no string holds without memory",
                                 "another texture with a name that no string holds without memory",
                                 "a sum with a name that no string holds without memory"};
    size_t declaring = 0, compiling = 0;
    for (int frame = 0; frame < 24; ++frame) {
        renderer.BeginFrame();
        const size_t begin = testing::AllocationCount();
        TextureId a = renderer.CreateTexture(names[0], {.extent = kExtent, .format = Format::R32Float});
        renderer.AddPass(
            names[0], PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/fill.comp");
                a = pass.Writes("target", a);
                pass.Constants(1.0f);
            },
            [extent = kExtent, unused = std::array<double, 8>{}](CommandList& commands) {
                std::ignore = unused;
                commands.DispatchOver(extent);
            });
        TextureId sum = renderer.Persist(names[2], {.extent = kExtent, .format = Format::R32Float});
        const uint32_t isFirst = renderer.IsFresh(sum) ? 1 : 0;
        renderer.AddPass(
            names[1], PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/add.comp");
                pass.Reads("source", a);
                sum = pass.Updates("sum", sum);
                pass.Constants(isFirst);
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
        renderer.Present(sum);
        const size_t declared = testing::AllocationCount();
        renderer.Compile();
        const size_t compiled = testing::AllocationCount();
        renderer.Execute();  // the validation layer allocates, so that raygraph_graph_cost looks at this
        if (frame < 12) continue;
        declaring += declared - begin;
        compiling += compiled - declared;
    }
    EXPECT_EQ(declaring, 0u);
    EXPECT_EQ(compiling, 0u);
    Device().WaitIdle();
}

}  // namespace
}  // namespace raygraph::repeated_frame_test
