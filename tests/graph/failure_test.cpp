#include <gmock/gmock.h>
#include <stdexcept>

#include "renderer/graph/pass_declaration.h"
#include "tests/graph/graph_test.h"
#include "tests/rhi/fake_loader.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"

// Failures in a frame: exceptions drop the frame and nothing else, mistakes are named, a lost device
// names the pass.
namespace raygraph::failure_test {
namespace {

using ::testing::HasSubstr;

constexpr Extent2D kExtent{16, 16};

template <typename Action>
std::string MessageOf(Action&& action) {
    return testing::ErrorOf(action).what();
}

class Failure : public GraphTest {
  protected:
    // A whole frame that works: what a Renderer must still do after any mistake.
    void ExpectGoodFrame() {
        m_renderer.BeginFrame();
        const Readback readback =
            m_renderer.ReadBack(Scale(m_renderer, "b", Fill(m_renderer, "a", kExtent, 1.0f), 3.0f));
        m_renderer.Execute();
        EXPECT_TRUE(IsRamp(Read(readback), 1.0f, 3.0f));
    }
};

TEST_F(Failure, ExceptionInSetup_DropsTheFrame) {
    m_renderer.BeginFrame();
    EXPECT_THROW(m_renderer.AddPass(
                     "Throws", PassKind::Compute, [](PassBuilder&) { throw std::runtime_error("mine"); },
                     [](CommandList&) {}),
                 std::runtime_error);
    EXPECT_EQ(MessageOf([&] { m_renderer.Execute(); }),
              R"(Execute: the frame is given up, since pass "Throws" was not declared)");
    ExpectGoodFrame();
}

TEST_F(Failure, ExceptionInExecute_DropsTheFrameAndItsStates) {
    const auto frame = [&](bool throws) {
        m_renderer.BeginFrame();
        const TextureId sum = AddTo(m_renderer, "sum", Fill(m_renderer, "one", kExtent, 1.0f));
        const Readback readback = m_renderer.ReadBack(sum);
        m_renderer.AddPass(
            "Throws", PassKind::Transfer, [](PassBuilder& pass) { pass.KeepAlive(); },
            [throws](CommandList&) {
                if (throws) throw std::runtime_error("mine");
            });
        m_renderer.Execute();
        return readback;
    };
    frame(false);
    EXPECT_THROW(frame(true), std::runtime_error);
    EXPECT_TRUE(IsRamp(Read(frame(false)), 1.0f, 2.0f)) << "the dropped frame added nothing";
    ExpectGoodFrame();
}

TEST_F(Failure, FrameThatIsNeverExecuted_IsDropped) {
    m_renderer.BeginFrame();
    m_renderer.Present(Fill(m_renderer, "a", kExtent, 1.0f));
    ExpectGoodFrame();
}

TEST_F(Failure, DeclaringOutsideOfAFrame) {
    EXPECT_EQ(MessageOf([&] { m_renderer.CreateTexture("a", {.extent = kExtent}); }),
              "CreateTexture: no frame has been begun (BeginFrame)");
    EXPECT_EQ(MessageOf([&] { m_renderer.Execute(); }), "Execute: no frame has been begun (BeginFrame)");
}

TEST_F(Failure, UnknownShader_NamesThoseOfItsStage) {
    m_renderer.BeginFrame();
    EXPECT_THAT(MessageOf([&] {
                    m_renderer.AddPass(
                        "Fill", PassKind::Compute, [](PassBuilder& pass) { pass.Compute("tst/fill.comp"); },
                        [](CommandList&) {});
                }),
                R"(pass "Fill": no shader "tst/fill.comp"; there is test/fill.comp)");
}

TEST_F(Failure, UnknownBinding_NamesWhatThereIs) {
    m_renderer.BeginFrame();
    TextureId target = m_renderer.CreateTexture("a", {.extent = kExtent, .format = Format::R32Float});
    EXPECT_EQ(
        MessageOf([&] {
            m_renderer.AddPass(
                "Fill", PassKind::Compute,
                [&](PassBuilder& pass) {
                    pass.Compute("test/fill.comp");
                    target = pass.Writes("targt", target);
                },
                [](CommandList&) {});
        }),
        R"(pass "Fill" binds "targt": no such binding; test/fill.comp has target (storage image, write))");
    ExpectGoodFrame();
}

TEST_F(Failure, ResourceThatThePassDidNotDeclare) {
    m_renderer.BeginFrame();
    const TextureId a = Fill(m_renderer, "a", kExtent, 1.0f);
    m_renderer.AddPass(
        "Copy", PassKind::Transfer, [](PassBuilder& pass) { pass.KeepAlive(); },
        [a](CommandList&, const PassResources& resources) { std::ignore = resources.Texture(a); });
    EXPECT_EQ(MessageOf([&] { m_renderer.Execute(); }),
              R"(pass "Copy" asks for "a", which it did not declare in its setup)");
    ExpectGoodFrame();
}

TEST_F(Failure, PersistentResourceDeclaredTwiceDifferently) {
    m_renderer.BeginFrame();
    const GraphTextureDesc desc{.extent = kExtent, .format = Format::R32Float};
    EXPECT_EQ(m_renderer.Persist("sum", desc), m_renderer.Persist("sum", desc));
    EXPECT_EQ(MessageOf([&] {
                  m_renderer.Persist("sum", {.extent = {4, 4}, .format = Format::R32Float});
              }),
              R"(Persist "sum": it was declared in this frame with another description)");
}

TEST_F(Failure, BuffersOfUnfitMemory) {
    m_renderer.BeginFrame();
    EXPECT_EQ(
        MessageOf([&] { m_renderer.CreateBuffer("b", {.size = 4, .memory = rhi::MemoryKind::Readback}); }),
        R"(buffer "b": Readback memory is what ReadBack uses)");
    EXPECT_THAT(
        MessageOf([&] { m_renderer.PersistBuffer("b", {.size = 4, .memory = rhi::MemoryKind::Upload}); }),
        HasSubstr("would be written while frames in flight read it"));
    EXPECT_EQ(MessageOf([&] { m_renderer.CreateBuffer("b", {}); }), R"(buffer "b": its size is zero)");
    EXPECT_EQ(MessageOf([&] { m_renderer.CreateTexture("t", {}); }),
              R"(texture "t": its extent 0x0 is empty)");
}

TEST_F(Failure, LostDevice_NamesTheLastPassReached) {
    m_renderer.BeginFrame();
    m_renderer.Present(Scale(m_renderer, "b", Fill(m_renderer, "a", kExtent, 1.0f), 3.0f));
    m_renderer.Execute();
    Device().WaitIdle();
    // lavapipe cannot be made to lose its device: the path from the result to the Error is what is tested
    // here.
    EXPECT_THAT(MessageOf([&] { Device().Check(VK_ERROR_DEVICE_LOST, "vkQueueSubmit2"); }),
                HasSubstr(R"(the last pass reached was pass "Scale b" (2 of 2) of frame 1)"));
}

TEST_F(Failure, LostDevice_NamesThePassOfEveryRenderer) {
    Renderer first(Device(), {.name = "viewport"});
    Renderer second(Device(), {.name = "thumbnails"});
    const Renderer idle(Device(), {.name = "idle"});
    AddTestShaders(first);
    AddTestShaders(second);
    for (Renderer* renderer : {&first, &second}) {
        renderer->BeginFrame();
        renderer->Present(Fill(*renderer, renderer == &first ? "a" : "b", kExtent, 1.0f));
        renderer->Execute();
    }
    Device().WaitIdle();
    EXPECT_EQ(
        MessageOf([&] { Device().Check(VK_ERROR_DEVICE_LOST, "x"); }),
        R"(x: VK_ERROR_DEVICE_LOST; renderer "viewport": the last pass reached was pass "Fill a" (1 of 1) )"
        R"(of frame 1; renderer "thumbnails": the last pass reached was pass "Fill b" (1 of 1) of frame 1)");
}

TEST_F(Failure, LostDevice_AfterAnotherRendererIsGone) {
    m_renderer.BeginFrame();
    m_renderer.Present(Fill(m_renderer, "a", kExtent, 1.0f));
    m_renderer.Execute();
    Device().WaitIdle();
    { Renderer other(Device()); }
    EXPECT_THAT(MessageOf([&] { Device().Check(VK_ERROR_DEVICE_LOST, "x"); }), HasSubstr(R"(pass "Fill a")"));
}

TEST_F(Failure, OnSubmitted_RunsOnceForASubmittedFrameOnly) {
    int count = 0;
    const auto frame = [&](bool throws) {
        m_renderer.BeginFrame();
        m_renderer.OnSubmitted([&] { ++count; });
        m_renderer.AddPass(
            "May throw", PassKind::Transfer, [](PassBuilder& pass) { pass.KeepAlive(); },
            [&count, throws](CommandList&) {
                EXPECT_EQ(count, 0);
                if (throws) throw std::runtime_error("mine");
            });
        const std::weak_ptr<const void> open = m_renderer.OpenFrame();
        EXPECT_FALSE(open.expired());
        if (throws)
            EXPECT_THROW(m_renderer.Execute(), std::runtime_error);
        else
            m_renderer.Execute();
        EXPECT_TRUE(open.expired());
    };
    frame(true);
    EXPECT_EQ(count, 0);
    frame(false);
    EXPECT_EQ(count, 1);
}

TEST_F(Failure, LostDevice_AfterTheRendererIsGone) {
    { Renderer other(Device()); }
    EXPECT_THAT(MessageOf([&] { Device().Check(VK_ERROR_DEVICE_LOST, "vkQueueSubmit2"); }),
                HasSubstr("no pass is known"));
}

}  // namespace
}  // namespace raygraph::failure_test

// Mistakes in declaring a frame: each throws Error{Usage} with one line that names the pass, the resource and
// the reason.
namespace raygraph::misuse_test {
namespace {

constexpr Access kRead = Access::StorageRead, kWrite = Access::StorageWrite;

TextureId Made(GraphMaker& graph, const char* name = "radiance") {
    return graph.Pass("Make", {}, graph.Texture(name));
}
// A pass of its own uses the id.
void Use(GraphMaker& graph, TextureId id, Access access, const Subresources& part = {},
         PassKind kind = PassKind::Compute) {
    graph.AddPass("Blur", kind);
    std::ignore = graph.Use(id, access, part);
}
// One pass uses the id twice.
void UseTwice(GraphMaker& graph, TextureId id, Access first, Access second,
              const Subresources& firstPart = {}, const Subresources& secondPart = {}) {
    Use(graph, id, first, firstPart);
    std::ignore = graph.Use(id, second, secondPart);
}
// A chain of 4 levels and 2 layers, of which levels 0 and 1 and layer 0 of level 2 have been written.
TextureId PartlyMade(GraphMaker& graph) {
    TextureId chain = graph.Fill("Make", graph.Chain("chain", 4, 2), Levels(0, 2));
    return graph.Fill("More", chain, Subresource(2, 0));
}
TextureId WholeChain(GraphMaker& graph) {
    return graph.Fill("Make", graph.Chain("chain", 4, 2));
}

// The last call of each is the mistake.
struct Mistake {
    const char* what;
    void (*make)(GraphMaker& graph);
    const char* expected;
};
constexpr Mistake kMistakes[] = {
    {"a stale id",
     [](GraphMaker& graph) {
         const TextureId before = Made(graph);
         std::ignore = graph.Pass("Second", {}, before);
         Use(graph, before, kRead);
     },
     R"(pass "Blur" reads "radiance" as it was before pass "Second" wrote it: use the id that the write returned)"},
    {"a version that is written twice",
     [](GraphMaker& graph) {
         const TextureId target = graph.Texture("radiance");
         std::ignore = graph.Pass("First", {}, target);
         Use(graph, target, kWrite);
     },
     R"(pass "Blur" writes "radiance" as it was before pass "First" wrote it: use the id that the write returned)"},
    {"an id from before a write of another level",
     [](GraphMaker& graph) {
         const TextureId before = graph.Fill("Make", graph.Chain("chain", 2), Level(0));
         std::ignore = graph.Fill("More", before, Level(1));
         Use(graph, before, Access::Sampled, Level(0));
     },
     R"(pass "Blur" reads "chain" as it was before pass "More" wrote it: use the id that the write returned)"},
    {"an empty id", [](GraphMaker& graph) { Use(graph, TextureId{}, kRead); },
     R"(pass "Blur" reads an empty texture id, which names no resource)"},
    {"an id of an earlier frame",
     [](GraphMaker& graph) {
         const TextureId old = graph.Texture("radiance");
         graph.Begin(4);
         std::ignore = graph.Texture("radiance");
         Use(graph, old, kWrite);
     },
     R"(pass "Blur" writes a texture id of an earlier frame (3 before this one): ids last for one frame)"},
    {"an id of another graph",
     [](GraphMaker& graph) {
         GraphMaker other;
         std::ignore = other.Texture("a");
         const TextureId second = other.Texture("b");
         std::ignore = graph.Texture("c");
         Use(graph, second, kWrite);
     },
     R"(pass "Blur" writes a texture id that this frame did not give out: it is of another Renderer)"},
    {"a read of a transient that nothing wrote",
     [](GraphMaker& graph) { Use(graph, graph.Texture("radiance"), kRead); },
     R"(pass "Blur" reads "radiance", a transient texture that nothing has written in this frame)"},
    {"an update of one",
     [](GraphMaker& graph) { Use(graph, graph.Texture("radiance"), Access::StorageUpdate); },
     R"(pass "Blur" updates "radiance", a transient texture that nothing has written in this frame)"},
    {"one that is shown", [](GraphMaker& graph) { graph.Present(graph.Texture("radiance")); },
     R"(Present shows "radiance", a transient texture that nothing has written in this frame)"},
    {"a level that nothing wrote",
     [](GraphMaker& graph) { Use(graph, graph.Chain("chain", 4, 2), Access::Sampled, Level(2)); },
     R"(pass "Blur" reads "chain" level 2, a transient texture that nothing has written in this frame)"},
    {"levels of which one is missing",
     [](GraphMaker& graph) { Use(graph, PartlyMade(graph), Access::Sampled, Levels(1, 2)); },
     R"(pass "Blur" reads "chain" levels 1-2, a transient texture whose level 2 layer 1 nothing has written in this frame)"},
    {"an update of a chain of which a level is missing",
     [](GraphMaker& graph) { Use(graph, PartlyMade(graph), Access::StorageUpdate); },
     R"(pass "Blur" updates "chain", a transient texture whose level 3 layer 0 nothing has written in this frame)"},
    {"such a chain that is shown", [](GraphMaker& graph) { graph.Present(PartlyMade(graph)); },
     R"(Present shows "chain", a transient texture whose level 3 layer 0 nothing has written in this frame)"},
    {"the levels of it that are there",
     [](GraphMaker& graph) {
         const TextureId chain = PartlyMade(graph);
         Use(graph, chain, Access::Sampled, Levels(0, 2));
         Use(graph, chain, kRead, Subresource(2, 0));
     },
     "accepted"},
    {"an import without contents",
     [](GraphMaker& graph) { Use(graph, graph.Imported<ResourceKind::Texture>("host"), Access::Sampled); },
     R"(pass "Blur" reads "host", imported in the layout Undefined: it has no contents until it is written)"},
    {"a level of an import without contents",
     [](GraphMaker& graph) {
         const TextureId host = graph.Chain("host", 2, 1, 0, Origin::Imported);
         Use(graph, graph.Fill("Make", host, Level(0)), Access::Sampled);
     },
     R"(pass "Blur" reads "host", imported in the layout Undefined: its level 1 has no contents until it is written)"},
    {"an access that a transfer cannot do",
     [](GraphMaker& graph) { Use(graph, graph.Texture("radiance"), kWrite, {}, PassKind::Transfer); },
     R"(pass "Blur" uses "radiance" as storage write, which a pass of kind transfer cannot do)"},
    {"an access that ray tracing cannot do",
     [](GraphMaker& graph) {
         Use(graph, graph.Texture("radiance"), Access::ColorWrite, {}, PassKind::RayTracing);
     },
     R"(pass "Blur" uses "radiance" as color target, which a pass of kind ray tracing cannot do)"},
    {"reading and writing in one pass",
     [](GraphMaker& graph) { UseTwice(graph, Made(graph), kRead, kWrite); },
     R"(pass "Blur" uses "radiance" both as storage read and as storage write: a pass that reads what it writes updates it)"},
    {"writing twice in one pass",
     [](GraphMaker& graph) {
         graph.AddPass("Blur", PassKind::Compute);
         const TextureId once = graph.Use(graph.Texture("radiance"), kWrite);
         std::ignore = graph.Use(once, kWrite);
     },
     R"(pass "Blur" uses "radiance" both as storage write and as storage write: a pass writes a resource once)"},
    {"sampling and loading in one pass",
     [](GraphMaker& graph) { UseTwice(graph, Made(graph), kRead, Access::Sampled); },
     R"(pass "Blur" uses "radiance" both as storage read and as sampled: a pass sees a texture in one way only)"},
    {"reading and writing one level in one pass",
     [](GraphMaker& graph) { UseTwice(graph, WholeChain(graph), kRead, kWrite, Levels(0, 2), Levels(1, 2)); },
     R"(pass "Blur" uses "chain" level 1 both as storage read and as storage write: a pass that reads what it writes updates it)"},
    {"sampling and loading one level in one pass",
     [](GraphMaker& graph) {
         UseTwice(graph, WholeChain(graph), kRead, Access::Sampled, Levels(0, 2), Subresource(0, 1));
     },
     R"(pass "Blur" uses "chain" level 0 layer 1 both as storage read and as sampled: a pass sees a texture in one way only)"},
    {"writing another level of what is read",
     [](GraphMaker& graph) { UseTwice(graph, WholeChain(graph), kRead, kWrite, Levels(0, 2), Level(3)); },
     "accepted"},
    {"writing a layer of levels that are read",
     [](GraphMaker& graph) { UseTwice(graph, WholeChain(graph), kRead, kWrite, Levels(0, 2), Layer(1)); },
     R"(pass "Blur" uses "chain" levels 0-1 layer 1 both as storage read and as storage write: a pass that reads what it writes updates it)"},
    {"a level that is not there",
     [](GraphMaker& graph) { Use(graph, graph.Chain("chain", 5), kWrite, Level(5)); },
     R"(pass "Blur" writes "chain": level 5, there are 5)"},
    {"levels that are not there",
     [](GraphMaker& graph) { Use(graph, graph.Chain("chain", 5), kWrite, Levels(3, 4)); },
     R"(pass "Blur" writes "chain": levels 3-6, there are 5)"},
    {"a layer that is not there",
     [](GraphMaker& graph) { Use(graph, graph.Chain("chain", 5), kWrite, Subresource(0, 2)); },
     R"(pass "Blur" writes "chain": layer 2, there is 1)"},
    {"combined uses of a set of structures in a build",
     [](GraphMaker& graph) {
         BlasSetId blases = graph.Imported<ResourceKind::BlasSet>("blases");
         graph.AddPass("Build", PassKind::AccelerationStructure);
         graph.Use(blases, Access::BuildRead);
         blases = graph.Use(graph.Use(blases, Access::BuildWrite), Access::BuildUpdate);
         EXPECT_EQ(blases.version, 2u);
     },
     "accepted"},
    {"a shown texture that is written later",
     [](GraphMaker& graph) {
         const TextureId made = Made(graph);
         graph.Present(made);
         std::ignore = graph.Pass("Again", {}, made);
         Compile(graph);
     },
     R"("radiance" was presented and written again later in the frame: its contents at the end of the frame are not those that were meant)"},
    {"an export of what was not imported",
     [](GraphMaker& graph) { graph.Export(Made(graph), VK_IMAGE_LAYOUT_GENERAL); },
     R"(Export hands back "radiance", a transient texture: only imported ones have an owner)"},
    {"an export without contents",
     [](GraphMaker& graph) {
         graph.Export(graph.Imported<ResourceKind::Texture>("host"), VK_IMAGE_LAYOUT_UNDEFINED);
     },
     R"(Export hands back "host" in a layout that drops its contents)"},
    {"two exports of one texture",
     [](GraphMaker& graph) {
         const TextureId host = graph.Pass("Make", {}, graph.Imported<ResourceKind::Texture>("host"));
         graph.Export(host, VK_IMAGE_LAYOUT_GENERAL);
         graph.Export(host, VK_IMAGE_LAYOUT_GENERAL);
     },
     R"(Export hands back "host" twice)"},
};

TEST(Misuse, EachMistake_IsNamedWithItsPassAndResource) {
    for (const Mistake& mistake : kMistakes) {
        GraphMaker graph;
        EXPECT_EQ(testing::ErrorTextOf([&] { mistake.make(graph); }), mistake.expected) << mistake.what;
    }
}

TEST(Misuse, FailedUse_LeavesTheGraphAsItWas) {
    GraphMaker graph;
    const TextureId target = graph.Texture("radiance");
    EXPECT_NE(testing::ErrorTextOf([&] { Use(graph, target, kRead); }), "accepted");
    EXPECT_TRUE(graph.uses.empty());
    EXPECT_EQ(graph.resources[0].version, 0u);
}

// Tells what is refused of a part under the name "image" of a binding that a shader declares.
std::string BindingRefusal(const GraphMaker& maker, TextureId texture, const Subresources& part,
                           rhi::BindingKind kind, rhi::ImageShape shape) {
    GraphMaker graph = maker;
    graph.AddPass("Look", PassKind::Compute);
    rhi::BindingInfo info;
    info.name = "image";
    info.kind = kind;
    info.shape = shape;
    info.firstShader = "look.comp";
    rhi::ShaderInterface interface;
    interface.bindings.push_back(info);
    const rhi::Sampler sampler;
    const bool isSampled = kind == rhi::BindingKind::SampledImage;
    PassDeclaration pass;
    pass.Clear(PassKind::Compute, nullptr);
    return testing::ErrorTextOf([&] {
        AddBinding(graph, pass, "image", texture, BindVerb::Reads,
                   isSampled ? Access::Sampled : Access::StorageRead, isSampled ? &sampler : nullptr, part);
        ResolveBindings(graph, pass, &interface);
    });
}

TEST(Misuse, ViewThatTheShaderCannotHave) {
    using enum rhi::ImageShape;
    using enum rhi::BindingKind;
    GraphMaker graph;
    const TextureId faces = graph.Fill("Make", graph.Chain("faces", 3, 6));
    const auto refusal = [&](const Subresources& part, rhi::BindingKind kind, rhi::ImageShape shape) {
        return BindingRefusal(graph, faces, part, kind, shape);
    };
    EXPECT_EQ(refusal({}, StorageImage, Array),
              R"(pass "Look" binds "image" to 3 levels of "faces": a storage image is one, as in Level(0))");
    EXPECT_EQ(
        refusal(Level(0), StorageImage, Plain),
        R"(pass "Look" binds "image" to 6 layers of "faces": in look.comp it is a 2D image, of one layer, as in Layer(0))");
    EXPECT_EQ(
        refusal(Layers(1, 2), SampledImage, Plain),
        R"(pass "Look" binds "image" to 2 layers of "faces": in look.comp it is a 2D image, of one layer, as in Layer(0))");
    EXPECT_EQ(
        refusal(Layer(0), SampledImage, Cube),
        R"(pass "Look" binds "image" to 1 layer of 64x64 of "faces": in look.comp it is a cube map, of six square layers)");
    EXPECT_EQ(refusal({}, SampledImage, Cube), "accepted");
    EXPECT_EQ(refusal(Level(2), StorageImage, Array), "accepted");
    EXPECT_EQ(refusal(Layer(5), SampledImage, Plain), "accepted") << "all levels of one layer";
    EXPECT_EQ(refusal(Subresource(1, 5), StorageImage, Plain), "accepted");

    graph.resources[faces.resource].extent = {64, 32};
    EXPECT_EQ(
        refusal({}, SampledImage, Cube),
        R"(pass "Look" binds "image" to 6 layers of 64x32 of "faces": in look.comp it is a cube map, of six square layers)");
}

TEST(Misuse, TargetsThatDoNotFitTogether) {
    GraphMaker graph;
    const TextureId faces = graph.Fill("Make", graph.Chain("faces", 3, 6));
    Shader plain, layered;
    layered.name = "layers.vert";
    layered.reflection.writesLayer = true;
    const auto refusal = [&](const std::vector<Subresources>& targets, const Shader* vertex = nullptr,
                             bool hasLayeredTargets = true) {
        PassDeclaration pass;
        pass.Clear(PassKind::Raster, nullptr);
        pass.request.vertex = vertex ? vertex : &plain;
        graph.AddPass("Draw", PassKind::Raster);
        for (const Subresources& part : targets)
            pass.colors.push_back({.index = static_cast<uint32_t>(pass.colors.size()),
                                   .resource = faces.resource,
                                   .load = {},
                                   .part = rhi::Resolved(part, 3, 6)});
        return testing::ErrorTextOf([&] { ResolveTargets(graph, pass, hasLayeredTargets); });
    };
    EXPECT_EQ(
        refusal({Level(1)}),
        R"(pass "Draw" draws to 6 layers of "faces", but its vertex shader does not write gl_Layer; one is Layer(0))");
    EXPECT_EQ(
        refusal({Level(1)}, &layered, false),
        R"(pass "Draw" runs layers.vert, which writes gl_Layer, but the device has no layered targets (shaderOutputLayer))");
    EXPECT_EQ(refusal(std::vector<Subresources>(9, Subresource(1, 0)), &plain),
              R"(pass "Draw" has 9 color targets, at most 8)");
    EXPECT_EQ(refusal({Level(1)}, &layered), "accepted");
    const Subresources two{.level = 1, .levelCount = 1, .layer = 0, .layerCount = 2};
    EXPECT_EQ(refusal({two, Subresource(1, 3)}, &layered),
              R"(pass "Draw" draws to 2 layers of "faces" and to 1 layer of "faces")");
    EXPECT_EQ(refusal({Layer(1)}),
              R"(pass "Draw" draws to 3 levels of "faces": a target is one level, as in Level(0))");
    EXPECT_EQ(refusal({Subresource(1, 2), Subresource(2, 2)}),
              R"(pass "Draw" draws to "faces" of 32x32 and to "faces" of 16x16)");
    EXPECT_EQ(refusal({Subresource(1, 2), Subresource(1, 3)}), "accepted");
}

}  // namespace
}  // namespace raygraph::misuse_test

// A dropped frame still serves the semaphores of the host: what the host has signaled is waited for, and what
// it waits for is signaled.
namespace raygraph::dropped_semaphores_test {
namespace {

constexpr Extent2D kExtent{16, 16};

// A binary semaphore of the host.
class BinarySemaphore {
  public:
    explicit BinarySemaphore(rhi::Device& device) : m_device(device) {
        const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, nullptr, 0};
        device.Check(device.Vk().vkCreateSemaphore(device.Handle(), &info, nullptr, &m_semaphore), "binary");
    }
    ~BinarySemaphore() { m_device.Vk().vkDestroySemaphore(m_device.Handle(), m_semaphore, nullptr); }
    BinarySemaphore(const BinarySemaphore&) = delete;
    BinarySemaphore& operator=(const BinarySemaphore&) = delete;
    rhi::SemaphoreUse Use() const { return {m_semaphore, 0}; }

  private:
    rhi::Device& m_device;
    VkSemaphore m_semaphore = VK_NULL_HANDLE;
};

// A host that signals `before` ahead of each frame and waits for `after` behind it.
struct Host {
    explicit Host(rhi::Device& d) : device(d), before(d), after(d), progress(d) {}
    ~Host() { device.WaitIdle(); }

    void Signal() {
        const rhi::SemaphoreUse signal = before.Use();
        device.Submit(device.BeginCommands("host, before"), {}, {&signal, 1});
    }
    void Declare(Renderer& renderer) {
        renderer.WaitSemaphore(before.Use());
        renderer.SignalSemaphore(after.Use());
        renderer.SignalSemaphore(progress.At(++frames));
    }
    // Submits work that waits for `after`, if the frame has signaled it.
    ::testing::AssertionResult GoesOn() {
        const uint64_t value = frames;
        const VkSemaphore semaphore = progress.At(value).semaphore;
        const VkSemaphoreWaitInfo wait{
            VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, nullptr, 0, 1, &semaphore, &value};
        if (device.Vk().vkWaitSemaphores(device.Handle(), &wait, 2'000'000'000ull) != VK_SUCCESS)
            return ::testing::AssertionFailure() << "the frame signals nothing";
        const rhi::SemaphoreUse use = after.Use();
        device.Submit(device.BeginCommands("host, after"), {&use, 1});
        device.WaitIdle();
        return ::testing::AssertionSuccess();
    }

    rhi::Device& device;
    BinarySemaphore before, after;
    testing::Gate progress;  // counts the frames
    uint64_t frames = 0;
};

class DroppedSemaphores : public GraphTest {
  protected:
    enum class Where { Nowhere, Setup, Execute };

    static void DeclareFrame(Renderer& renderer, Where throwing) {
        renderer.Present(Fill(renderer, "a", kExtent, 1.0f));
        renderer.AddPass(
            "May throw", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.KeepAlive();
                if (throwing == Where::Setup) throw std::runtime_error("setup");
            },
            [throwing](CommandList&) {
                if (throwing == Where::Execute) throw std::runtime_error("execute");
            });
    }
    void Frame(Where throwing) {
        m_renderer.BeginFrame();
        m_host.Declare(m_renderer);
        DeclareFrame(m_renderer, throwing);
        m_renderer.Execute();
    }

    Host m_host{Device()};
};

TEST_F(DroppedSemaphores, AreForwardedWhenRecordingFails) {
    for (const Where where : {Where::Execute, Where::Execute, Where::Nowhere}) {
        m_host.Signal();
        if (where == Where::Execute)
            EXPECT_THROW(Frame(where), std::runtime_error);
        else
            Frame(where);
        ASSERT_TRUE(m_host.GoesOn());
    }
}

TEST_F(DroppedSemaphores, AreForwardedByDropFrameAfterAnErrorInASetup) {
    m_host.Signal();
    EXPECT_THROW(Frame(Where::Setup), std::runtime_error);
    m_renderer.DropFrame();
    ASSERT_TRUE(m_host.GoesOn());
    m_renderer.DropFrame();  // has nothing left to signal
    m_host.Signal();
    Frame(Where::Nowhere);
    ASSERT_TRUE(m_host.GoesOn());
}

TEST_F(DroppedSemaphores, AreForwardedByTheNextBeginFrame) {
    m_host.Signal();
    EXPECT_THROW(Frame(Where::Setup), std::runtime_error);
    m_renderer.BeginFrame();
    ASSERT_TRUE(m_host.GoesOn());
    m_renderer.DropFrame();
}

TEST_F(DroppedSemaphores, AreForwardedByTheRenderersEnd) {
    m_host.Signal();
    {
        Renderer other(Device());
        AddTestShaders(other);
        other.BeginFrame();
        m_host.Declare(other);
    }
    ASSERT_TRUE(m_host.GoesOn());
}

TEST_F(DroppedSemaphores, AreLeftAloneWhereAskedFor) {
    m_host.Signal();
    m_renderer.BeginFrame();
    m_renderer.WaitSemaphore(m_host.before.Use(), DropPolicy::LeaveAlone);
    m_renderer.SignalSemaphore(m_host.progress.At(1), DropPolicy::LeaveAlone);
    m_renderer.DropFrame();
    Device().WaitIdle();
    EXPECT_EQ(m_host.progress.Value(), 0u);
    Frame(Where::Nowhere);  // `before` is still there to be waited for
    ASSERT_TRUE(m_host.GoesOn());
}

// The host has not signaled yet: Vulkan allows no wait for it.
TEST_F(DroppedSemaphores, AreLeftAloneByADropThatIsToldSo) {
    m_renderer.BeginFrame();
    m_host.Declare(m_renderer);
    m_renderer.DropFrame(DropPolicy::LeaveAlone);
    Device().WaitIdle();
    EXPECT_EQ(m_host.progress.Value(), 0u);
    m_host.Signal();
    Frame(Where::Nowhere);
    ASSERT_TRUE(m_host.GoesOn());
}

TEST(DroppedSemaphoresOfAFailedSubmission, AreForwarded) {
    testing::FakeLoader loader;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = loader.Entry()});
    Renderer renderer(*device);
    Host host(*device);
    host.Signal();
    renderer.BeginFrame();
    host.Declare(renderer);
    renderer.AddPass(
        "Nothing", PassKind::Transfer, [](PassBuilder& pass) { pass.KeepAlive(); }, [](CommandList&) {});
    loader.Tell().nextSubmitResult = VK_ERROR_OUT_OF_HOST_MEMORY;
    EXPECT_EQ(testing::ErrorOf([&] { renderer.Execute(); }).Kind(), ErrorKind::OutOfMemory);
    EXPECT_TRUE(host.GoesOn());
}

}  // namespace
}  // namespace raygraph::dropped_semaphores_test
