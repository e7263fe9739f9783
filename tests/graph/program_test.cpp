// How long programs and their pipelines are kept.
#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"

namespace raygraph {

namespace {

constexpr Extent2D kExtent{4, 4};

class ProgramLife : public GraphTest {
  protected:
    // A frame that fills, and scales as well; how many pipelines there have been.
    static uint32_t Frame(Renderer& renderer, bool isScaled) {
        renderer.BeginFrame();
        const TextureId filled = GraphTest::Fill(renderer, "filled", kExtent, 1.0f);
        renderer.Present(isScaled ? Scale(renderer, "scaled", filled, 2.0f) : filled);
        renderer.Execute();
        return renderer.PipelineCount();
    }
};

}  // namespace

TEST_F(ProgramLife, OneThatNoFrameDeclares_IsLetGoAfterItsTime) {
    EXPECT_EQ(Frame(m_renderer, true), 2u);
    m_renderer.ForgetPipelines(0.0);
    EXPECT_EQ(Frame(m_renderer, true), 2u) << "the last frame declared both";
    EXPECT_EQ(Frame(m_renderer, false), 2u);
    m_renderer.ForgetPipelines(300.0);
    EXPECT_EQ(Frame(m_renderer, true), 2u) << "too early";
    EXPECT_EQ(Frame(m_renderer, false), 2u);
    m_renderer.ForgetPipelines(0.0);
    EXPECT_EQ(Frame(m_renderer, true), 3u);
    EXPECT_EQ(Frame(m_renderer, true), 3u);
}

TEST_F(ProgramLife, ACulledPass_KeepsIts) {
    EXPECT_EQ(Frame(m_renderer, true), 2u);
    m_renderer.BeginFrame();
    const TextureId filled = GraphTest::Fill(m_renderer, "filled", kExtent, 1.0f);
    static_cast<void>(Scale(m_renderer, "unseen", filled, 2.0f));
    m_renderer.Present(filled);
    m_renderer.Execute();
    m_renderer.ForgetPipelines(0.0);
    EXPECT_EQ(Frame(m_renderer, true), 2u);
}

// Of culled passes, too, and of no others.
TEST_F(ProgramLife, PipelinesOfPassesArePreparedBeforeAFrameUsesThem) {
    Renderer& renderer = m_renderer;
    renderer.BeginFrame();
    const PassId first = renderer.NextPass();
    const TextureId filled = GraphTest::Fill(renderer, "filled", kExtent, 1.0f);
    const PassId second = renderer.NextPass();
    static_cast<void>(Scale(renderer, "unseen", filled, 2.0f));
    EXPECT_TRUE(renderer.PreparePipelines(second, second)) << "of no pass";
    EXPECT_TRUE(renderer.HasPipelines(second, second));
    for (int i = 0; i < 2; ++i) EXPECT_FALSE(renderer.HasPipelines(first, renderer.NextPass()));
    EXPECT_FALSE(renderer.IsPreparingPipelines()) << "asking begins nothing";
    while (!renderer.PreparePipelines(second, renderer.NextPass())) {
    }
    EXPECT_TRUE(renderer.HasPipelines(second, renderer.NextPass()));
    EXPECT_FALSE(renderer.HasPipelines(first, renderer.NextPass())) << "not that of the first pass";
    EXPECT_EQ(renderer.PipelineReports().size(), 1u) << "none was asked for of the first pass";
    while (!renderer.PreparePipelines(first, renderer.NextPass())) {
    }
    EXPECT_EQ(renderer.PipelineReports().size(), 2u);
    for (const PassId end : {PassId{}, PassId{renderer.NextPass().index + 1}}) {
        EXPECT_NE(testing::ErrorTextOf([&] { renderer.PreparePipelines(first, end); }), "") << "of no pass";
        EXPECT_NE(testing::ErrorTextOf([&] { std::ignore = renderer.HasPipelines(first, end); }), "");
    }
    renderer.Present(filled);
    renderer.Execute();
    EXPECT_EQ(renderer.PipelineCount(), 2u);
    EXPECT_NE(testing::ErrorTextOf([&] { renderer.PreparePipelines(first, second); }), "")
        << "no frame is open";
}

}  // namespace raygraph
