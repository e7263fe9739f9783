// Shaders from source: loaded by name, reloaded when their text or an include changes, last good pipeline
// kept.
#include <gmock/gmock.h>

#include <fstream>

#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

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
