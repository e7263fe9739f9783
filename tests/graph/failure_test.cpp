// Failures in a frame: exceptions drop the frame and nothing else, mistakes are named, a lost device
// names the pass.
#include <gmock/gmock.h>

#include <stdexcept>

#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"

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
