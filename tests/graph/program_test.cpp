// Which passes share a program, and how long programs and their pipelines are kept.
#include <algorithm>
#include <functional>
#include <thread>

#include "renderer/graph/program.h"
#include "tests/graph/graph_test.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/error_of.h"
#include "tests/support/option_rows.h"

namespace raygraph::program_test {

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

// A request that nobody makes, of each part something, in a cache that holds it.
class ProgramRequests : public testing::VulkanTest {
  protected:
    struct Row {
        std::string name;
        std::function<void(ProgramRequest&)> change;
    };

    ProgramRequests() {
        m_plain.kind = PassKind::Raster;
        m_plain.rayGen = m_plain.compute = m_plain.vertex = m_plain.fragment = m_one;
        m_plain.miss.fill(m_one);
        m_plain.hitSets.push_back({});
        m_plain.hitSets[0].fill({m_one, m_one, m_one});
        m_plain.callables = {m_one};
        m_plain.specialization = {{"kCount", 1}, {"kOther", 2}};
        m_plain.colorFormats = {Format::Rgba8Unorm};
    }

    // A program for each value of an enumeration but that of m_plain.
    template <typename Enum, typename Member>
    static void AddValues(std::vector<Row>& rows, const char* name, Enum plain, Member member) {
        for (uint32_t i = 0; i < testing::EnumeratorCount<Enum>(); ++i) {
            const auto value = static_cast<Enum>(i);
            if (value != plain)
                rows.push_back({name + (" " + std::to_string(i)),
                                [=](ProgramRequest& request) { member(request) = value; }});
        }
    }
    std::vector<Row> Rows() const {
        const Shader* other = m_other;
        std::vector<Row> rows = {
            {"ray generation", [=](ProgramRequest& r) { r.rayGen = other; }},
            {"compute", [=](ProgramRequest& r) { r.compute = other; }},
            {"vertex", [=](ProgramRequest& r) { r.vertex = other; }},
            {"fragment", [=](ProgramRequest& r) { r.fragment = other; }},
            {"no fragment", [=](ProgramRequest& r) { r.fragment = nullptr; }},
            {"one more hit set", [=](ProgramRequest& r) { r.hitSets.push_back(r.hitSets[0]); }},
            {"callable", [=](ProgramRequest& r) { r.callables[0] = other; }},
            {"one more callable", [=](ProgramRequest& r) { r.callables.push_back(r.callables[0]); }},
            {"recursion", [](ProgramRequest& r) { r.maxRecursion = 2; }},
            {"constant", [](ProgramRequest& r) { r.specialization[0].name = "kCounts"; }},
            {"its value", [](ProgramRequest& r) { r.specialization[0].value = 3; }},
            {"the next one's value", [](ProgramRequest& r) { r.specialization[1].value = 1; }},
            {"one constant less", [](ProgramRequest& r) { r.specialization.pop_back(); }},
            {"color format", [](ProgramRequest& r) { r.colorFormats[0] = Format::Rgba8Srgb; }},
            {"one more target", [](ProgramRequest& r) { r.colorFormats.push_back(Format::Rgba8Unorm); }},
            {"no front", [](ProgramRequest& r) { r.raster.isFrontClockwise = true; }},
            {"no depth is written", [](ProgramRequest& r) { r.raster.writesDepth = false; }},
            {"wireframe", [](ProgramRequest& r) { r.raster.isWireframe = true; }}};
        for (size_t ray = 0; ray < kRayTypeCount; ++ray) {
            rows.push_back({"miss", [=](ProgramRequest& r) { r.miss[ray] = other; }});
            for (const Shader* HitShaders::*stage :
                 {&HitShaders::closestHit, &HitShaders::anyHit, &HitShaders::intersection})
                for (const Shader* shader : {other, static_cast<const Shader*>(nullptr)})
                    rows.push_back({"hit", [=](ProgramRequest& r) { r.hitSets[0][ray].*stage = shader; }});
        }
        AddValues(
            rows, "kind", m_plain.kind, [](auto& r) -> auto& { return r.kind; });
        AddValues(
            rows, "depth", m_plain.depthFormat, [](auto& r) -> auto& { return r.depthFormat; });
        const RasterState state;
        AddValues(
            rows, "topology", state.topology, [](auto& r) -> auto& { return r.raster.topology; });
        AddValues(
            rows, "cull", state.cull, [](auto& r) -> auto& { return r.raster.cull; });
        AddValues(
            rows, "compare", state.depthCompare, [](auto& r) -> auto& { return r.raster.depthCompare; });
        AddValues(
            rows, "blend", state.blend, [](auto& r) -> auto& { return r.raster.blend; });
        return rows;
    }

    ShaderLibrary m_library{{}};
    const Shader* m_one = &m_library.Add("test/one.comp", Counting("one.comp"));
    const Shader* m_other = &m_library.Add("test/other.comp", Counting("other.comp"));
    ProgramCache m_cache{Device()};
    ProgramRequest m_plain;

  private:
    static std::vector<uint32_t> Counting(std::string_view name) {
        return CompileText(name, R"(
layout(constant_id = 0) const uint kCount = 0;
layout(constant_id = 1) const uint kOther = 0;
layout(binding = 0, scalar) buffer Result { uint result; };
void main() { result = kCount + kOther; })");
    }
};

auto FieldsOf(ProgramRequest& s) {
    auto& [kind, rayGen, miss, hitSets, callables, maxRecursion, compute, vertex, fragment, specialization,
           raster, colorFormats, depthFormat] = s;
    auto& [topology, cull, isFrontClockwise, depthCompare, writesDepth, blend, isWireframe] = raster;
    return std::tie(kind, rayGen, miss, hitSets, callables, maxRecursion, compute, vertex, fragment,
                    specialization, topology, cull, isFrontClockwise, depthCompare, writesDepth, blend,
                    isWireframe, colorFormats, depthFormat);
}

}  // namespace

// Two pipelines that differ only in how they blend would else be one.
TEST_F(ProgramRequests, EveryPart_MakesAnotherProgram) {
    const Program& program = m_cache.Add(m_plain, "pass");
    EXPECT_EQ(m_cache.Find(ProgramRequest(m_plain)), &program);
    auto rows = testing::OptionRowsOf<ProgramRequest>([](ProgramRequest& s) { return FieldsOf(s); });
    for (const Row& row : Rows()) {
        ProgramRequest changed = m_plain;
        row.change(changed);
        rows.Add(row.name, m_plain, changed);
        EXPECT_EQ(m_cache.Find(changed), nullptr) << row.name;
    }
    rows.ExpectComplete();
    EXPECT_EQ(m_cache.Find(m_plain), &program);
}

// Passes reuse their requests from frame to frame.
TEST_F(ProgramRequests, OneThatIsCleared_IsAsANewOne) {
    for (const Row& row : Rows()) {
        ProgramRequest changed = m_plain;
        row.change(changed);
        changed.Clear(PassKind::Raster);
        EXPECT_EQ(changed, ProgramRequest{.kind = PassKind::Raster}) << row.name;
    }
}

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
        EXPECT_NE(testing::ErrorTextOf([&] { renderer.PreparePipelines(first, end); }), "accepted")
            << "of no pass";
        EXPECT_NE(testing::ErrorTextOf([&] { std::ignore = renderer.HasPipelines(first, end); }), "accepted");
    }
    renderer.Present(filled);
    renderer.Execute();
    EXPECT_EQ(renderer.PipelineCount(), 2u);
    EXPECT_NE(testing::ErrorTextOf([&] { renderer.PreparePipelines(first, second); }), "accepted")
        << "no frame is open";
}

// A driver compiles on the thread that asks: one after the other they would take the sum of their times.
TEST_F(ProgramLife, PipelinesOfAFrame_AreMadeAtOnce) {
    testing::FakeLoader loader;
    loader.Tell().computePipelinesAtOnce = 3;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = loader.Entry()});
    {
        Renderer renderer(*device);
        AddTestShaders(renderer);
        renderer.BeginFrame();
        const TextureId filled = GraphTest::Fill(renderer, "filled", kExtent, 1.0f);
        const TextureId scaled = Scale(renderer, "twice", Scale(renderer, "once", filled, 2.0f), 2.0f);
        renderer.Present(AddTo(renderer, "sum", scaled));
        renderer.Execute();
        EXPECT_EQ(renderer.PipelineCount(), 3u);
    }
    EXPECT_FALSE(loader.Tell().areComputePipelinesAlone);
}

// The frame is dropped by the first Error; the others, of threads that have ended by then, are not those of the next.
TEST_F(ProgramLife, PipelinesThatFailTogether_CostOneFrame) {
    testing::FakeLoader loader;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = loader.Entry()});
    Renderer renderer(*device);
    AddTestShaders(renderer);
    loader.Tell().computePipelinesAtOnce = 2;
    loader.Tell().computePipelineResult = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    EXPECT_NE(testing::ErrorTextOf([&] { Frame(renderer, true); }, ErrorKind::OutOfMemory), "accepted");
    EXPECT_FALSE(loader.Tell().areComputePipelinesAlone) << "only one has failed";
    EXPECT_FALSE(renderer.IsPreparingPipelines());
    EXPECT_EQ(renderer.PipelineCount(), 0u);
    loader.Tell().computePipelineResult = VK_SUCCESS;
    EXPECT_EQ(Frame(renderer, true), 2u);
}

// There the order decides the numbers of shader groups, which machine code on disk contains.
TEST_F(ProgramLife, RayTracingPipelinesOfAFrame_AreMadeInOrderOnLavapipe) {
    testing::FakeLoader loader;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = loader.Entry()});
    {
        Renderer renderer(*device);
        renderer.BeginFrame();
        for (const char* name : {"first.rgen", "second.rgen", "third.rgen"}) {
            renderer.AddShader(name, rhi::CompileGlsl({.name = name,
                                                       .text = R"(#version 460
                                                           #extension GL_EXT_ray_tracing : require
                                                           layout(binding = 0, r32f) uniform image2D target;
                                                           void main() { imageStore(target, ivec2(0), vec4(1)); }
                                                       )",
                                                       .stage = rhi::StageKind::RayGen}));
            TextureId target = renderer.CreateTexture(name, {.extent = kExtent, .format = Format::R32Float});
            renderer.AddPass(
                name, PassKind::RayTracing,
                [&](PassBuilder& pass) {
                    pass.RayGen(name);
                    target = pass.Writes("target", target);
                    pass.KeepAlive();
                },
                [](CommandList& commands) { commands.TraceRays(kExtent); });
        }
        renderer.Execute();
        EXPECT_EQ(renderer.PipelineCount(), 3u);
    }
    const std::vector<std::thread::id>& makers = loader.Tell().rayTracingMakers;
    ASSERT_EQ(makers.size(), 3u);
    const auto here = std::ranges::count(makers, std::this_thread::get_id());
    EXPECT_EQ(here, device->Info().isLavapipe ? 3 : 1);
}

}  // namespace raygraph::program_test
