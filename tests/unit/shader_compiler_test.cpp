#include "rhi/shader_compiler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

#include "base/error.h"
#include "shaders/embedded.h"
#include "tests/support/error_of.h"
#include "tests/support/source_file.h"

namespace raygraph::rhi::shader_compiler_test {
namespace {

namespace fs = std::filesystem;

// Has a folder of its own that is removed with the test.
class ShaderCompiler : public ::testing::Test {
  protected:
    void SetUp() override {
        std::string pattern = (fs::temp_directory_path() / "raygraph-shaders-XXXXXX").string();
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        m_root = pattern;
    }
    void TearDown() override { fs::remove_all(m_root); }

    void Write(const std::string& name, const std::string& text) const {
        fs::create_directories((m_root / name).parent_path());
        std::ofstream(m_root / name, std::ios::binary) << text;
    }

    std::string ErrorOf(const GlslSource& source) const {
        const Error error = testing::ErrorOf([&] { CompileGlsl(source); });
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        return error.what();
    }

    fs::path m_root;
};

std::vector<uint32_t> ReadWords(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    std::vector<uint32_t> words(bytes.size() / 4);
    bytes.copy(reinterpret_cast<char*>(words.data()), words.size() * 4);
    return words;
}

constexpr const char* kInclude = "#version 460\n#extension GL_GOOGLE_include_directive : require\n";

TEST_F(ShaderCompiler, WordsAreThoseOfTheBuildTimeCompiler) {
    Write("lib/color.glsl", "#include \"tint.glsl\"\nvec3 Color(float x) { return kTint * sqrt(x); }\n");
    Write("lib/tint.glsl", "const vec3 kTint = vec3(0.1, 0.5, 0.9);\n");
    const std::string rayGen = std::string(kInclude) + R"(#extension GL_EXT_ray_tracing : require
        #include "lib/color.glsl"
        layout(constant_id = 2) const uint kMode = 3;
        layout(set = 0, binding = 0) uniform accelerationStructureEXT tlas;
        layout(set = 0, binding = 1, rgba32f) uniform writeonly image2D radiance;
        layout(location = 0) rayPayloadEXT vec4 payload;
        void main() {
            for (uint i = 0; i < kMode; ++i)
                traceRayEXT(tlas, 0, 0xff, 0, 1, 0, vec3(i), 0.0, vec3(0, 0, 1), 1e9, 0);
            imageStore(radiance, ivec2(gl_LaunchIDEXT.xy), vec4(Color(payload.x), 1));
        })";
    const std::string compute =
        "#version 460\nlayout(local_size_x = 64) in;\n"
        "layout(binding = 0) buffer Data { float data[]; };\n"
        "void main() { data[gl_GlobalInvocationID.x] *= 2.0; }\n";
    for (const auto& [name, text] : {std::pair{"trace/a.rgen", rayGen}, std::pair{"double.comp", compute}}) {
        Write(name, text);
        const std::string command = std::string(RAYGRAPH_GLSLANG) + " --quiet -V --target-env vulkan1.3 -I" +
                                    m_root.string() + " -o " + (m_root / "out.spv").string() + " " +
                                    (m_root / name).string();
        ASSERT_EQ(std::system(command.c_str()), 0) << command;
        const std::vector<uint32_t> expected = ReadWords(m_root / "out.spv");
        ASSERT_FALSE(expected.empty());
        EXPECT_EQ(CompileGlslFile({.name = name, .includeRoot = m_root}), expected) << name;
    }
}

TEST_F(ShaderCompiler, EmbeddedShadersCompileToTheSameWords) {
    const fs::path root = test::SourceFile("shaders");
    ASSERT_FALSE(EmbeddedShaders().empty());
    for (const EmbeddedShader& shader : EmbeddedShaders()) {
        const std::vector<uint32_t> words = CompileGlslFile({.name = std::string(shader.source),
                                                             .preamble = std::string(shader.preamble),
                                                             .stage = StageOfFile(shader.name),
                                                             .includeRoot = root});
        EXPECT_TRUE(std::equal(words.begin(), words.end(), shader.Words().begin(), shader.Words().end()))
            << shader.name;
    }
}

TEST_F(ShaderCompiler, ErrorNamesFileAndLine) {
    const GlslSource source{.name = "post/wrong.comp",
                            .text = "#version 460\nvoid main() {\n    float x = undefinedName;\n}\n",
                            .stage = {},
                            .includeRoot = m_root};
    EXPECT_EQ(ErrorOf(source), "post/wrong.comp:3: 'undefinedName' : undeclared identifier");
}

TEST_F(ShaderCompiler, PreambleDefinesMacrosAndIsNotCounted) {
    GlslSource source{.name = "half.comp",
                      .text = "#version 460\n#ifdef WRONG\nwrong\n#endif\nvoid main() {}\n",
                      .preamble = "#define RIGHT 1\n#define WRONG\n"};
    EXPECT_THAT(ErrorOf(source), ::testing::StartsWith("half.comp:3: "));
    source.preamble.clear();
    EXPECT_NO_THROW(CompileGlsl(source));
}

TEST_F(ShaderCompiler, ErrorInAnIncludedFileNamesThatFile) {
    Write("lib/broken.glsl", "\n\nfloat Broken() { return vec2(1); }\n");
    const std::string error =
        ErrorOf({.name = "a/b.comp",
                 .text = std::string(kInclude) + "#include \"lib/broken.glsl\"\nvoid main() {}\n",
                 .stage = {},
                 .includeRoot = m_root});
    EXPECT_EQ(error.substr(0, 18), "lib/broken.glsl:3:") << error;
}

TEST_F(ShaderCompiler, MissingIncludeNamesTheLineThatAsksForIt) {
    const std::string error =
        ErrorOf({.name = "a/b.comp",
                 .text = std::string(kInclude) + "#include \"lib/absent.glsl\"\nvoid main() {}\n",
                 .stage = {},
                 .includeRoot = m_root});
    EXPECT_EQ(error.substr(0, 11), "a/b.comp:3:") << error;
    EXPECT_NE(error.find("lib/absent.glsl"), std::string::npos) << error;
}

TEST_F(ShaderCompiler, AtMostFiveErrorsAreListed) {
    std::string text = "#version 460\nvoid main() {\n";
    for (int i = 0; i < 9; ++i) text.append("x").append(std::to_string(i)).append(" = 1;\n");
    const std::string error = ErrorOf({.name = "many.comp", .text = text + "}\n", .stage = {}});
    EXPECT_LE(std::count(error.begin(), error.end(), '\n'), 5);
    EXPECT_NE(error.find("many.comp:3: 'x0'"), std::string::npos) << error;
}

TEST_F(ShaderCompiler, StageIsAskedForWhenTheSuffixNamesNone) {
    const GlslSource source{.name = "a.glsl", .text = "#version 460\nvoid main() {}", .stage = {}};
    EXPECT_EQ(testing::ErrorOf([&] { CompileGlsl(source); }).Kind(), ErrorKind::Usage);
}

TEST_F(ShaderCompiler, IncludesAreSearchedNextToTheIncluderThenInTheRoot) {
    Write("near/value.glsl", "const float kValue = 1.0;\n");
    Write("value.glsl", "const float kFar = 2.0;\n");
    Write("near/user.glsl", "#include \"value.glsl\"\n");
    Write("root.glsl", "const float kRoot = 3.0;\n");
    const GlslSource source{
        .name = "far/main.comp",
        .text = std::string(kInclude) +
                "#include \"near/user.glsl\"\n#include \"value.glsl\"\n#include \"root.glsl\"\n"
                "layout(binding = 0) buffer O { float o; };\n"
                "void main() { o = kValue + kFar + kRoot; }\n",
        .stage = {},
        .includeRoot = m_root};
    std::vector<fs::path> files;
    EXPECT_NO_THROW(CompileGlsl(source, &files));
    const std::vector<fs::path> expected{m_root / "near/user.glsl", m_root / "near/value.glsl",
                                         m_root / "value.glsl", m_root / "root.glsl"};
    EXPECT_EQ(files, expected);
}

TEST_F(ShaderCompiler, OtherRootsAreSearchedAfterTheOwnOne) {
    Write("own/value.glsl", "const float kOwn = 1.0;\n");
    Write("library/value.glsl", "#error not this one\n");
    Write("library/core/color.glsl", "#include \"core/glue.glsl\"\n");
    Write("library/core/glue.glsl", "const float kGlue = 2.0;\n");
    Write("own/main.comp", std::string(kInclude) +
                               "#include \"value.glsl\"\n#include \"core/color.glsl\"\n"
                               "layout(binding = 0) buffer O { float o; };\n"
                               "void main() { o = kOwn + kGlue; }\n");
    std::vector<fs::path> files;
    EXPECT_NO_THROW(CompileGlslFile(
        {.name = "main.comp", .includeRoot = m_root / "own", .moreIncludes = {m_root / "library"}}, &files));
    const std::vector<fs::path> expected{m_root / "own/value.glsl", m_root / "library/core/color.glsl",
                                         m_root / "library/core/glue.glsl"};
    EXPECT_EQ(files, expected);
}

TEST_F(ShaderCompiler, FileThatIsNotThereIsAnIoError) {
    EXPECT_EQ(
        testing::ErrorOf([&] { CompileGlslFile({.name = "absent.comp", .includeRoot = m_root}); }).Kind(),
        ErrorKind::Io);
}

TEST_F(ShaderCompiler, ThreadsCompileAtTheSameTimeToTheSameWords) {
    auto compile = [] {
        return CompileGlsl(
            {.name = "t.comp",
             .text = "#version 460\nlayout(binding = 0) buffer O { float o; };\nvoid main() { o = sin(o); }",
             .stage = {},
             .includeRoot = {}});
    };
    constexpr int kThreadCount = 4;
    std::vector<std::vector<uint32_t>> words(kThreadCount);
    std::vector<std::thread> threads;
    for (int i = 0; i < kThreadCount; ++i)
        threads.emplace_back([&, i] {
            for (int k = 0; k < 8; ++k) words[static_cast<size_t>(i)] = compile();
        });
    for (std::thread& thread : threads) thread.join();
    for (const auto& result : words) EXPECT_EQ(result, words[0]);
    EXPECT_FALSE(words[0].empty());
}

}  // namespace
}  // namespace raygraph::rhi::shader_compiler_test
