#include <gmock/gmock.h>
#include <algorithm>
#include <fstream>
#include <functional>
#include <thread>

#include "renderer/graph/program.h"
#include "shaders/shared/draw_records.h"
#include "tests/graph/graph_test.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/error_of.h"
#include "tests/support/option_rows.h"
#include "tests/support/temporary_folder.h"

// Which passes share a program, and how long programs and their pipelines are kept.
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
        m_plain.hitGroups = {{0, RayType::Radiance, m_one, m_one, m_one}};
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
            {"one more hit group", [=](ProgramRequest& r) { r.hitGroups.push_back(r.hitGroups[0]); }},
            {"hit set", [](ProgramRequest& r) { r.hitGroups[0].hitSet = 1; }},
            {"ray type", [](ProgramRequest& r) { r.hitGroups[0].rayType = RayType::Shadow; }},
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
        for (size_t ray = 0; ray < kRayTypeCount; ++ray)
            rows.push_back({"miss", [=](ProgramRequest& r) { r.miss[ray] = other; }});
        for (const Shader* HitGroupRequest::*stage :
             {&HitGroupRequest::closestHit, &HitGroupRequest::anyHit, &HitGroupRequest::intersection})
            for (const Shader* shader : {other, static_cast<const Shader*>(nullptr)})
                rows.push_back({"hit", [=](ProgramRequest& r) { r.hitGroups[0].*stage = shader; }});
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
    auto& [kind, rayGen, miss, hitGroups, callables, maxRecursion, compute, vertex, fragment, specialization,
           raster, colorFormats, depthFormat] = s;
    auto& [topology, cull, isFrontClockwise, depthCompare, writesDepth, blend, isWireframe] = raster;
    return std::tie(kind, rayGen, miss, hitGroups, callables, maxRecursion, compute, vertex, fragment,
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
    m_renderer.ReleasePipelines(0.0);
    EXPECT_EQ(Frame(m_renderer, true), 2u) << "the last frame declared both";
    EXPECT_EQ(Frame(m_renderer, false), 2u);
    m_renderer.ReleasePipelines(300.0);
    EXPECT_EQ(Frame(m_renderer, true), 2u) << "too early";
    EXPECT_EQ(Frame(m_renderer, false), 2u);
    m_renderer.ReleasePipelines(0.0);
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
    m_renderer.ReleasePipelines(0.0);
    EXPECT_EQ(Frame(m_renderer, true), 2u);
}

// Pipelines of culled passes are prepared, too, and no others.
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

// Shaders from source: loaded by name, reloaded when their text or an include changes, last good pipeline
// kept.
namespace raygraph::reload_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Reload : public testing::VulkanTest {
  protected:
    Reload() {
        Write("value.glsl", "const float kValue = 1.0;\n");
        Write("fill.comp", Text("kValue"));
        m_renderer = std::make_unique<Renderer>(Device(), RendererDesc{.shaderRoot = m_folder.Path()});
    }

    static std::string Text(const std::string& value) {
        return "#version 460\n"
               "#extension GL_GOOGLE_include_directive : require\n"
               "#include \"value.glsl\"\n"
               "layout(local_size_x = 8, local_size_y = 8) in;\n"
               "layout(binding = 0, r32f) uniform writeonly image2D target;\n"
               "void main() { imageStore(target, ivec2(gl_GlobalInvocationID.xy), vec4(" +
               value + ")); }\n";
    }
    void Write(const std::string& name, const std::string& text) {
        std::ofstream(m_folder / name, std::ios::binary) << text;
    }
    // Begins a frame with a pass that fills what is returned.
    TextureId Fill(const char* shader = "fill.comp") {
        m_renderer->BeginFrame();
        TextureId target =
            m_renderer->CreateTexture("target", {.extent = {8, 8}, .format = Format::R32Float});
        m_renderer->AddPass(
            "Fill", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute(shader);
                target = pass.Writes("target", target);
            },
            [](CommandList& commands) {
                commands.DispatchOver({8, 8});
            });
        return target;
    }
    float Value(const char* shader = "fill.comp") {
        const TextureId target = Fill(shader);
        const Readback readback = m_renderer->ReadBack(target);
        m_renderer->Execute();
        readback.Wait();
        return testing::As<float>(readback.Bytes())[0];
    }

    test::TemporaryFolder m_folder;
    testing::MessageLog m_heard;  // of a device that a test makes
    std::unique_ptr<Renderer> m_renderer;
};

TEST_F(Reload, ChangedText_IsUsedFromTheNextFrameOn) {
    EXPECT_EQ(Value(), 1.0f);
    Write("fill.comp", Text("2.0 * kValue"));
    EXPECT_EQ(Value(), 1.0f) << "not before ReloadShaders";
    EXPECT_THAT(m_renderer->ReloadShaders(), IsEmpty());
    EXPECT_EQ(Value(), 2.0f);
}

TEST_F(Reload, ChangedInclude_RecompilesWhatIncludesIt) {
    EXPECT_EQ(Value(), 1.0f);
    Write("value.glsl", "const float kValue = 7.0;\n");
    EXPECT_THAT(m_renderer->ReloadShaders(), IsEmpty());
    EXPECT_EQ(Value(), 7.0f);
}

TEST_F(Reload, Variant_IsItsSourceWithItsMacros) {
    const char* const plain = "scene/texture_level.comp";
    const char* const widened = "scene/texture_level_widened.comp";
    const auto write = [&](const std::string& value) {
        Write("scene/texture_level_main.glsl", Text("\n#ifdef WIDENED\n10.0 +\n#endif\n" + value + "\n"));
    };
    std::filesystem::create_directory(m_folder / "scene");
    write("1.0");
    EXPECT_EQ(Value(plain), 1.0f);
    EXPECT_EQ(Value(widened), 11.0f);
    write("2.0");
    EXPECT_THAT(m_renderer->ReloadShaders(), IsEmpty());
    EXPECT_EQ(Value(plain), 2.0f);
    EXPECT_EQ(Value(widened), 12.0f);
    write("wrong");
    EXPECT_THAT(m_renderer->ReloadShaders(),
                Contains(HasSubstr("scene/texture_level_main.glsl:10: 'wrong'")).Times(2));
    EXPECT_EQ(Value(widened), 12.0f);
}

TEST_F(Reload, BrokenText_KeepsTheLastGoodPipelineAndNamesTheLine) {
    EXPECT_EQ(Value(), 1.0f);
    Write("fill.comp", Text("kValu"));
    EXPECT_THAT(m_renderer->ReloadShaders(), ElementsAre(HasSubstr("fill.comp:6: 'kValu'")));
    EXPECT_EQ(Value(), 1.0f);
    EXPECT_THAT(m_renderer->ReloadShaders(), ElementsAre(HasSubstr("fill.comp:6: 'kValu'")))
        << "it is still broken";
    Write("fill.comp", Text("3.0"));
    EXPECT_THAT(m_renderer->ReloadShaders(), IsEmpty());
    EXPECT_EQ(Value(), 3.0f);
}

TEST_F(Reload, MissingInclude_IsFoundWhenItComesBack) {
    EXPECT_EQ(Value(), 1.0f);
    std::filesystem::remove(m_folder / "value.glsl");
    EXPECT_THAT(m_renderer->ReloadShaders(), ElementsAre(HasSubstr("value.glsl")));
    EXPECT_EQ(Value(), 1.0f);
    Write("value.glsl", "const float kValue = 4.0;\n");
    EXPECT_THAT(m_renderer->ReloadShaders(), IsEmpty());
    EXPECT_EQ(Value(), 4.0f);
}

TEST_F(Reload, UnchangedText_MakesNothingAnew) {
    EXPECT_EQ(Value(), 1.0f);
    const double spent = m_renderer->PipelineCreationMs();
    Write("fill.comp", Text("kValue"));
    EXPECT_THAT(m_renderer->ReloadShaders(), IsEmpty());
    EXPECT_EQ(Value(), 1.0f);
    EXPECT_EQ(m_renderer->PipelineCreationMs(), spent);
    EXPECT_EQ(m_renderer->PipelineCount(), 1u);
}

TEST_F(Reload, LogCountsWhatHasChangedAndSaysNothingOfNothing) {
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.validation = true, .log = m_heard.Listener(LogLevel::Info)});
    m_renderer = std::make_unique<Renderer>(*device, RendererDesc{.shaderRoot = m_folder.Path()});
    EXPECT_EQ(Value(), 1.0f);
    const size_t before = m_heard.Count();
    m_renderer->ReloadShaders();
    EXPECT_EQ(m_heard.Text(before), "");
    Write("fill.comp", Text("2.0"));
    m_renderer->ReloadShaders();
    EXPECT_THAT(m_heard.Text(before), HasSubstr("1 changed shader is reloaded in "));
    m_renderer.reset();
}

TEST_F(Reload, PipelineThatIsBeingMade_IsThatOfTheNewText) {
    m_renderer->Present(Fill());
    (void)m_renderer->PreparePipelines();
    m_renderer->DropFrame();
    Write("fill.comp", Text("5.0"));
    EXPECT_THAT(m_renderer->ReloadShaders(), IsEmpty());
    EXPECT_EQ(Value(), 5.0f);
    EXPECT_EQ(m_renderer->PipelineCount(), 1u);
}

TEST_F(Reload, WhileAFrameIsOpen_IsRefused) {
    EXPECT_EQ(Value(), 1.0f);
    m_renderer->BeginFrame();
    EXPECT_EQ(testing::ErrorTextOf([&] { m_renderer->ReloadShaders(); }),
              "ReloadShaders: a frame is open; it comes before BeginFrame or after Execute");
    m_renderer->DropFrame();
    EXPECT_THAT(m_renderer->ReloadShaders(), IsEmpty());
    EXPECT_EQ(Value(), 1.0f);
}

TEST_F(Reload, BrokenFromTheStart_IsAnErrorOfThePass) {
    Write("fill.comp", Text("kValu"));
    EXPECT_THAT(testing::ErrorTextOf([&] { Value(); }, ErrorKind::BadInput),
                HasSubstr("pass \"Fill\": fill.comp:6: 'kValu'"));
    Write("fill.comp", Text("kValue"));
    EXPECT_EQ(Value(), 1.0f);
}

// SPIR-V that is handed in, under one name.
class AddedShader : public GraphTest {
  protected:
    static std::vector<uint32_t> Words(const std::string& value) {
        return CompileText("test/value.comp",
                           "layout(local_size_x = 8, local_size_y = 8) in;\n"
                           "layout(binding = 0, r32f) uniform writeonly image2D target;\n"
                           "void main() { imageStore(target, ivec2(gl_GlobalInvocationID.xy), vec4(" +
                               value + ")); }\n");
    }
    TextureId Declare() {
        TextureId target = m_renderer.CreateTexture("target", {.extent = {8, 8}, .format = Format::R32Float});
        m_renderer.AddPass(
            "Value", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/value.comp");
                target = pass.Writes("target", target);
            },
            [](CommandList& commands) {
                commands.DispatchOver({8, 8});
            });
        return target;
    }
    float Value() {
        m_renderer.BeginFrame();
        const Readback readback = m_renderer.ReadBack(Declare());
        m_renderer.Execute();
        return Read(readback).values.front();
    }
    // The message of the Error{Usage} of adding the words.
    std::string Refusal(const std::vector<uint32_t>& words) {
        return testing::ErrorTextOf([&] { m_renderer.AddShader("test/value.comp", words); });
    }
};

TEST_F(AddedShader, OtherWordsUnderAKnownName_AreUsedFromTheNextFrameOn) {
    m_renderer.AddShader("test/value.comp", Words("1.0"));
    EXPECT_EQ(Value(), 1.0f);
    m_renderer.AddShader("test/value.comp", Words("2.0"));
    EXPECT_EQ(Value(), 2.0f);
    EXPECT_EQ(m_renderer.PipelineCount(), 1u);
    const double spent = m_renderer.PipelineCreationMs();
    m_renderer.AddShader("test/value.comp", Words("2.0"));
    EXPECT_EQ(m_renderer.PipelineCreationMs(), spent) << "the same words make nothing";
}

TEST_F(AddedShader, OtherWordsWhileAFrameIsOpen_AreRefused) {
    m_renderer.AddShader("test/value.comp", Words("1.0"));
    m_renderer.BeginFrame();
    const Readback readback = m_renderer.ReadBack(Declare());
    EXPECT_EQ(Refusal(Words("2.0")),
              R"(AddShader "test/value.comp": a frame is open, and its passes were checked against the )"
              "shader of that name; it comes before BeginFrame or after Execute");
    m_renderer.AddShader("test/value.comp", Words("1.0"));
    m_renderer.AddShader("test/new.comp", Words("3.0"));
    m_renderer.Execute();
    EXPECT_EQ(Read(readback).values.front(), 1.0f);
    m_renderer.AddShader("test/value.comp", Words("2.0"));
    EXPECT_EQ(Value(), 2.0f);
}

TEST_F(AddedShader, WordsThatDoNotFit_LeaveTheOneThatWasThere) {
    m_renderer.AddShader("test/value.comp", Words("1.0"));
    EXPECT_EQ(Value(), 1.0f);
    const std::vector<uint32_t> vertex = [] {
        rhi::GlslSource source;
        source.name = "test/value.vert";
        source.text = "#version 460\nvoid main() { gl_Position = vec4(0.0); }\n";
        return rhi::CompileGlsl(source);
    }();
    EXPECT_THAT(Refusal(vertex),
                HasSubstr(R"(AddShader "test/value.comp": the one that was there stays, since )"));
    EXPECT_EQ(Value(), 1.0f);
}

}  // namespace
}  // namespace raygraph::reload_test

// Raster passes: state, targets, depth, loads.
namespace raygraph::raster_test {
namespace {

using ::testing::ElementsAre;

constexpr Extent2D kExtent{32, 32};

class Raster : public GraphTest {
  protected:
    Raster() {
        m_renderer.AddShader("test/triangles.vert", CompileText("test/triangles.vert", R"(
struct Vertex { vec2 position; float depth; };
layout(binding = 0, scalar) readonly buffer Vertices { Vertex vertices[]; };
void main() {
    Vertex vertex = vertices[gl_VertexIndex];
    gl_Position = vec4(vertex.position, vertex.depth, 1.0);
})"));
        m_renderer.AddShader("test/color.frag", CompileText("test/color.frag", R"(
layout(location = 0) out vec4 color;
layout(push_constant, std430) uniform Constants { vec4 color; } constants;
void main() { color = constants.color; })"));
    }

    struct Vertex {
        float x, y, depth;
    };
    struct Color {
        float r, g, b, a;
    };
    // The left upper half of the picture, at a depth.
    static std::vector<Vertex> Corner(float depth) {
        return {{-1, -1, depth}, {1, -1, depth}, {-1, 1, depth}};
    }
    static std::vector<Vertex> Everything(float depth) {
        return {{-1, -1, depth}, {3, -1, depth}, {-1, 3, depth}};
    }

    static TextureId Draw(Renderer& renderer, TextureId target, TextureId* depth, BufferId vertices,
                          const Color& color, bool clear, const RasterState& state = {}) {
        renderer.AddPass(
            "Draw", PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("test/triangles.vert").Fragment("test/color.frag").Raster(state);
                pass.Reads("Vertices", vertices);
                pass.Constants(color);
                target = pass.ColorTarget(0, target, {.clear = clear, .value = {0.25f, 0.25f, 0.25f, 1.0f}});
                if (depth) *depth = pass.DepthTarget(*depth, {.clear = clear});
            },
            [](CommandList& commands) { commands.Draw(3); });
        return target;
    }
};

TEST_F(Raster, TriangleByVertexPulling_CoversItsHalf) {
    testing::PassHarness harness(Device());
    harness.Graph().AddShader("test/triangles.vert", CompileText("test/triangles.vert", R"(
struct Vertex { vec2 position; float depth; };
layout(binding = 0, scalar) readonly buffer Vertices { Vertex vertices[]; };
void main() { gl_Position = vec4(vertices[gl_VertexIndex].position, vertices[gl_VertexIndex].depth, 1.0); })"));
    harness.Graph().AddShader("test/color.frag", CompileText("test/color.frag", R"(
layout(location = 0) out vec4 color;
layout(push_constant, std430) uniform Constants { vec4 color; } constants;
void main() { color = constants.color; })"));
    const testing::Texels texels = harness.Run([](testing::PassHarness& h) {
        const BufferId vertices = h.Buffer("vertices", Corner(0.5f));
        const TextureId target =
            h.Graph().CreateTexture("color", {.extent = kExtent, .format = Format::Rgba8Unorm});
        return Draw(h.Graph(), target, nullptr, vertices, {1.0f, 0.0f, 0.0f, 1.0f}, true);
    });
    EXPECT_THAT(texels.At(2, 2), ElementsAre(1.0f, 0.0f, 0.0f, 1.0f));
    EXPECT_THAT(texels.At(30, 30), ElementsAre(64 / 255.0f, 64 / 255.0f, 64 / 255.0f, 1.0f));
}

TEST_F(Raster, DepthTest_KeepsWhatIsNearer) {
    m_renderer.BeginFrame();
    const auto upload = [&](std::string_view name, const std::vector<Vertex>& vertices) {
        const BufferId buffer = m_renderer.CreateBuffer(
            name, {.size = vertices.size() * sizeof(Vertex), .memory = rhi::MemoryKind::Upload});
        m_renderer.AddPass(
            "Write " + std::string(name), PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(buffer);
                pass.KeepAlive();
            },
            [buffer, vertices](CommandList&, const PassResources& resources) {
                std::ranges::copy(std::as_bytes(std::span(vertices)),
                                  resources.Buffer(buffer).Mapped().begin());
            });
        return buffer;
    };
    const BufferId nearCorner = upload("near", Corner(0.2f));
    const BufferId farAll = upload("far", Everything(0.8f));
    TextureId depth = m_renderer.CreateTexture("depth", {.extent = kExtent, .format = Format::D32Float});
    TextureId color = m_renderer.CreateTexture("color", {.extent = kExtent, .format = Format::Rgba8Unorm});
    color = Draw(m_renderer, color, &depth, nearCorner, {1, 0, 0, 1}, true);
    color = Draw(m_renderer, color, &depth, farAll, {0, 1, 0, 1}, false);
    const Readback colors = m_renderer.ReadBack(color);
    const Readback depths = m_renderer.ReadBack(depth);
    m_renderer.Execute();
    EXPECT_THAT(Read(colors).At(2, 2), ElementsAre(1.0f, 0.0f, 0.0f, 1.0f));
    EXPECT_THAT(Read(colors).At(30, 30), ElementsAre(0.0f, 1.0f, 0.0f, 1.0f));
    EXPECT_THAT(Read(depths).At(2, 2), ElementsAre(0.2f));
    EXPECT_THAT(Read(depths).At(30, 30), ElementsAre(0.8f));
}

TEST_F(Raster, BlendedDraws_AddUp) {
    m_renderer.BeginFrame();
    TextureId color = m_renderer.CreateTexture("color", {.extent = kExtent, .format = Format::Rgba32Float});
    BufferId vertices =
        m_renderer.CreateBuffer("vertices", {.size = 3 * sizeof(Vertex), .memory = rhi::MemoryKind::Upload});
    m_renderer.AddPass(
        "Write", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(vertices);
            pass.KeepAlive();
        },
        [vertices](CommandList&, const PassResources& resources) {
            const std::vector<Vertex> all = Everything(0.5f);
            std::ranges::copy(std::as_bytes(std::span(all)), resources.Buffer(vertices).Mapped().begin());
        });
    for (int i = 0; i < 3; ++i)
        color = Draw(m_renderer, color, nullptr, vertices, {1.0f, 2.0f, 0.0f, 0.0f}, i == 0,
                     {.blend = rhi::BlendMode::Additive});
    const Readback readback = m_renderer.ReadBack(color);
    m_renderer.Execute();
    EXPECT_EQ(Read(readback).At(5, 5)[0], 3.25f);
    EXPECT_EQ(Read(readback).At(5, 5)[1], 6.25f);
}

TEST_F(Raster, DrawIndirect_DrawsItsRangeOfCommandsAndRefusesOneBeyondTheEnd) {
    const auto draw = [&](uint32_t first, uint32_t count) {
        m_renderer.BeginFrame();
        TextureId color =
            m_renderer.CreateTexture("color", {.extent = kExtent, .format = Format::Rgba8Unorm});
        const BufferId vertices = m_renderer.CreateBuffer(
            "vertices", {.size = 6 * sizeof(Vertex), .memory = rhi::MemoryKind::Upload});
        const BufferId commands = m_renderer.CreateBuffer(
            "commands", {.size = 2 * sizeof(gpu::DrawCommand), .memory = rhi::MemoryKind::Upload});
        m_renderer.AddPass(
            "Write", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(vertices);
                pass.CopiesFrom(commands);
                pass.KeepAlive();
            },
            [vertices, commands](CommandList&, const PassResources& resources) {
                std::vector<Vertex> all = Corner(0.5f);  // the upper left half, then the other
                for (const Vertex& vertex : Corner(0.5f)) all.push_back({-vertex.x, -vertex.y, 0.5f});
                const std::vector<gpu::DrawCommand> list{{3, 1, 0, 0}, {3, 1, 3, 0}};
                std::ranges::copy(std::as_bytes(std::span(all)), resources.Buffer(vertices).Mapped().begin());
                std::ranges::copy(std::as_bytes(std::span(list)),
                                  resources.Buffer(commands).Mapped().begin());
            });
        m_renderer.AddPass(
            "Draw", PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("test/triangles.vert").Fragment("test/color.frag");
                pass.Reads("Vertices", vertices);
                pass.ReadsArguments(commands);
                pass.Constants(Color{1, 1, 1, 1});
                color = pass.ColorTarget(0, color);
            },
            [=](CommandList& list, const PassResources& resources) {
                list.DrawIndirect(resources.Buffer(commands), first, count);
            });
        const Readback readback = m_renderer.ReadBack(color);
        m_renderer.Execute();
        const auto texels = Read(readback);
        return std::pair(texels.At(2, 2)[0], texels.At(29, 29)[0]);
    };
    EXPECT_EQ(draw(0, 1), std::pair(1.0f, 0.0f));
    EXPECT_EQ(draw(1, 1), std::pair(0.0f, 1.0f));
    EXPECT_EQ(draw(0, 2), std::pair(1.0f, 1.0f));
    EXPECT_EQ(draw(2, 0), std::pair(0.0f, 0.0f));
    EXPECT_EQ(testing::ErrorTextOf([&] { draw(1, 2); }),
              "DrawIndirect: draws 1 to 3 of 'commands', which holds 2");
}

struct StateRow {
    const char* name;
    void (*change)(RasterState&);
};
using rhi::BlendMode;
using rhi::CullMode;
using rhi::DepthCompare;
using rhi::Topology;
// Each row of kStates changes the picture that DrawnWith draws with kState.
constexpr RasterState kState{.cull = CullMode::Back};
const StateRow kStates[] = {
    {"strip", [](RasterState& s) { s.topology = Topology::TriangleStrip; }},
    {"lines", [](RasterState& s) { s.topology = Topology::LineList; }},
    {"points", [](RasterState& s) { s.topology = Topology::PointList; }},
    {"both sides", [](RasterState& s) { s.cull = CullMode::None; }},
    {"the other side", [](RasterState& s) { s.cull = CullMode::Front; }},
    {"the other front", [](RasterState& s) { s.isFrontClockwise = true; }},
    {"always", [](RasterState& s) { s.depthCompare = DepthCompare::Always; }},
    {"less", [](RasterState& s) { s.depthCompare = DepthCompare::Less; }},
    {"equal", [](RasterState& s) { s.depthCompare = DepthCompare::Equal; }},
    {"greater", [](RasterState& s) { s.depthCompare = DepthCompare::Greater; }},
    {"greater or equal", [](RasterState& s) { s.depthCompare = DepthCompare::GreaterOrEqual; }},
    {"no depth is written", [](RasterState& s) { s.writesDepth = false; }},
    {"alpha", [](RasterState& s) { s.blend = BlendMode::Alpha; }},
    {"premultiplied", [](RasterState& s) { s.blend = BlendMode::Premultiplied; }},
    {"additive", [](RasterState& s) { s.blend = BlendMode::Additive; }},
    {"wireframe", [](RasterState& s) { s.isWireframe = true; }},
};

class RasterStates : public testing::VulkanTest {
  protected:
    static void AddShaders(Renderer& renderer) {
        // Draws four overlapping triangles. The first three have the same winding; the second is behind the
        // first, the third at the same depth as the first. The fourth has the opposite winding.
        renderer.AddShader("test/four.vert", CompileText("test/four.vert", R"(
layout(location = 0) flat out vec4 color;
const vec2 kCorners[3] = vec2[](vec2(-0.9), vec2(-0.9, 0.9), vec2(0.9, -0.9));
const float kDepths[4] = float[](0.5, 0.75, 0.5, 0.25);
const vec4 kColors[4] =
    vec4[](vec4(1, 0, 0, 0.5), vec4(0, 1, 0, 0.5), vec4(0, 0, 1, 0.5), vec4(1, 1, 0, 0.25));
void main() {
    int triangle = gl_VertexIndex / 3, corner = gl_VertexIndex % 3;
    vec2 place = kCorners[triangle == 3 && corner > 0 ? 3 - corner : corner];
    gl_Position = vec4(place + 0.1 * float(triangle), kDepths[triangle], 1.0);
    gl_PointSize = 1.0;
    color = kColors[triangle];
})"));
        renderer.AddShader("test/flat.frag", CompileText("test/flat.frag", R"(
layout(location = 0) flat in vec4 color;
layout(location = 0) out vec4 result;
void main() { result = color; })"));
    }
    static std::vector<float> DrawnWith(Renderer& renderer, const RasterState& state) {
        renderer.BeginFrame();
        TextureId target =
            renderer.CreateTexture("color", {.extent = kExtent, .format = Format::Rgba32Float});
        TextureId depth = renderer.CreateTexture("depth", {.extent = kExtent, .format = Format::D32Float});
        renderer.AddPass(
            "Draw", PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("test/four.vert").Fragment("test/flat.frag").Raster(state);
                target = pass.ColorTarget(0, target, {.value = {0.25f, 0.25f, 0.25f, 1.0f}});
                depth = pass.DepthTarget(depth);
            },
            [](CommandList& commands) { commands.Draw(12); });
        const Readback readback = renderer.ReadBack(target);
        renderer.Execute();
        readback.Wait();
        return testing::As<float>(readback.Bytes());
    }
};

// If pipelines were looked up without a part of the state, both passes would draw one pipeline's picture.
TEST_F(RasterStates, PassesThatDifferInOnePartOfIt_DrawAsEachDoesAlone) {
    Renderer both(Device());
    AddShaders(both);
    const std::vector<float> plain = DrawnWith(both, kState);
    auto rows = testing::OptionRowsOf<RasterState>([](RasterState& s) {
        auto& [topology, cull, isFrontClockwise, depthCompare, writesDepth, blend, isWireframe] = s;
        return std::tie(topology, cull, isFrontClockwise, depthCompare, writesDepth, blend, isWireframe);
    });
    for (const StateRow& row : kStates) {
        SCOPED_TRACE(row.name);
        RasterState state = kState;
        row.change(state);
        rows.Add(row.name, kState, state);
        if (state.isWireframe && !Device().Info().optional.wireframe) continue;
        Renderer alone(Device());
        AddShaders(alone);
        const std::vector<float> picture = DrawnWith(both, state);
        EXPECT_NE(picture, plain);
        EXPECT_EQ(picture, DrawnWith(alone, state));
        EXPECT_EQ(DrawnWith(both, kState), plain);
    }
    rows.ExpectComplete();
}

TEST_F(Raster, ConstantsWithOneValueTooMany_AreRefused) {
    m_renderer.BeginFrame();
    const TextureId color =
        m_renderer.CreateTexture("color", {.extent = kExtent, .format = Format::Rgba8Unorm});
    const auto add = [&] {
        m_renderer.AddPass(
            "Draw", PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("test/triangles.vert").Fragment("test/color.frag");
                pass.Reads("Vertices",
                           m_renderer.CreateBuffer(
                               "vertices", {.size = 3 * sizeof(Vertex), .memory = rhi::MemoryKind::Upload}));
                pass.Constants(std::array<float, 5>{});
                [[maybe_unused]] const TextureId drawn = pass.ColorTarget(0, color, {.clear = true});
            },
            [](CommandList& commands) { commands.Draw(3); });
    };
    EXPECT_EQ(testing::ErrorTextOf(add),
              R"(pass "Draw" gives 20 bytes of constants; test/color.frag has 16 bytes of push constants)");
}

TEST_F(Raster, TargetsThatDoNotFit_AreRefused) {
    const auto message = [&](Extent2D second, Format format) {
        m_renderer.BeginFrame();
        TextureId a = m_renderer.CreateTexture("a", {.extent = kExtent, .format = Format::Rgba8Unorm});
        TextureId b = m_renderer.CreateTexture("b", {.extent = second, .format = format});
        return testing::ErrorTextOf([&] {
            m_renderer.AddPass(
                "Draw", PassKind::Raster,
                [&](PassBuilder& pass) {
                    pass.Vertex("test/triangles.vert").Fragment("test/color.frag");
                    a = pass.ColorTarget(0, a);
                    b = pass.DepthTarget(b);
                },
                [](CommandList&) {});
        });
    };
    EXPECT_EQ(message({8, 8}, Format::D32Float), R"(pass "Draw" draws to "a" of 32x32 and to "b" of 8x8)");
    EXPECT_EQ(message(kExtent, Format::Rgba8Unorm), R"(pass "Draw" has "b" of format rgba8 as depth target)");
}

}  // namespace
}  // namespace raygraph::raster_test
