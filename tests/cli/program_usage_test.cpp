// Tests messages and exit statuses of requests that the program refuses. It needs no device.
#include <fstream>

#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_usage_test {
namespace {

using test::ProgramResult;
using test::RunProgram;

// Expects one line on stderr that begins with the program's name and contains these texts, and nothing on
// stdout.
template <typename... Texts>
void ExpectFailure(const test::TemporaryFolder& folder, const char* line, int exitCode,
                   const Texts&... texts) {
    const ProgramResult result = RunProgram(folder, line);
    EXPECT_EQ(result.exitCode, exitCode) << result.messages;
    EXPECT_EQ(result.output, "");
    EXPECT_EQ(result.messages.find("raygraph: "), 0u) << result.messages;
    EXPECT_EQ(result.messages.find('\n') + 1, result.messages.size()) << result.messages;
    for (const std::string& text : {std::string(texts)...})
        EXPECT_NE(result.messages.find(text), std::string::npos) << result.messages << "lacks " << text;
}

TEST(Program, HelpAndVersionGoToStdout) {
    for (const char* option : {"--help", "--version"}) {
        const ProgramResult result = RunProgram(test::TemporaryFolder(), option);
        EXPECT_EQ(result.exitCode, 0);
        EXPECT_NE(result.output.find("raygraph"), std::string::npos);
        EXPECT_EQ(result.messages, "");
    }
}

TEST(Program, WrongUsageIsTwo) {
    const test::TemporaryFolder folder;
    ExpectFailure(folder, "", 2, "--help");
    ExpectFailure(folder, "render @cornell.gltf --bogus", 2, "--bogus");
    ExpectFailure(folder, "render @cornell.gltf --size 0x4", 2, "--size", "0x4");
    ExpectFailure(folder, "render @cornell.gltf -o a.tiff", 2, "a.tiff");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --aov albedo", 2, "--aov", ".exr");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --view raster --error 0.1", 2, "--view raster",
                  "--error");
    ExpectFailure(folder, "render @cornell.gltf -o a.exr --view raster --light-group a=light", 2,
                  "--view raster", "--light-group");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --view raster --max-depth 1", 2, "--view raster",
                  "--max-depth");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --shadows maps", 2, "--shadows", "--view raster");
    ExpectFailure(folder, "render @cornell.gltf -o a.exr --view albedo --aov direct", 2, "--aov direct",
                  "path-traced");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --light-group a=light", 2, "--light-group", ".exr");
    ExpectFailure(folder, "render @cornell.gltf -o a.exr --view albedo --light-group a=light", 2,
                  "--light-group");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --view depth --spp 4", 2, "depth", "--spp");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --view normals --exposure 1", 2, "normals",
                  "--exposure");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --view normals --tonemap agx", 2, "normals",
                  "--tonemap");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --view normals --nee off", 2, "normals", "--nee");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --view raster --mis off", 2, "raster", "--mis");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --view raster --aperture 1", 2, "raster",
                  "--aperture");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --view albedo --background 1,1,1", 2, "albedo",
                  "--background");
    ExpectFailure(folder, "render @cornell.gltf -o a.png --view albedo --env sky.hdr", 2, "albedo", "--env");
    // These options have an effect here, so only the scene is missing
    for (const char* line : {"render none.gltf --view raster --brdf lambert --multiscatter off",
                             "render none.gltf --view raster --background 1,1,1 --shadows maps",
                             "render none.gltf --view ray-cost --nee off --max-depth 2 --background 1,1,1",
                             "render none.gltf --view normals --spp 4 --sampler pcg --seed 2"})
        ExpectFailure(folder, line, 4, "none.gltf");
    ExpectFailure(folder, "render @cornell.gltf --sample-offset 4294967295 --spp 2 -o a.exr", 2,
                  "--sample-offset");
}

TEST(Program, BadInputIsFour) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "broken.gltf") << R"({"asset": {"version": "2.0"}, "scene": 3})";
    std::ofstream(folder / "sky.hdr") << "no picture";
    ExpectFailure(folder, "render none.gltf -o a.exr", 4, "none.gltf");
    ExpectFailure(folder, "render broken.gltf -o a.exr", 4, "broken.gltf");
    ExpectFailure(folder, "render @cornell.gltf --env sky.hdr -o a.exr", 4, "sky.hdr");
    ExpectFailure(folder, "render @cornell.gltf --env none.hdr -o a.exr", 4, "none.hdr");
    ExpectFailure(folder, "render @cornell.gltf --resume none.exr --spp 2", 4, "none.exr");
    ExpectFailure(folder, "info broken.gltf", 4, "broken.gltf");
    ExpectFailure(folder, "bench none.gltf", 4, "none.gltf");
    ExpectFailure(folder, "graph none.gltf", 4, "none.gltf");
    ExpectFailure(folder, "merge a.exr b.exr -o c.exr", 4, "a.exr");
    EXPECT_FALSE(std::filesystem::exists(folder / "a.exr") || std::filesystem::exists(folder / "c.exr"));
}

TEST(Program, AnOutputThatCannotBeWrittenIsOneBeforeAnythingIsRead) {
    const test::TemporaryFolder folder;
    // The scene does not exist either: the output is checked first
    ExpectFailure(folder, "render none.gltf -o missing/a.png", 1, "missing");
    ExpectFailure(folder, "render none.gltf -o a.png --report missing/r.json", 1, "missing");
    ExpectFailure(folder, "merge a.exr b.exr -o missing/c.exr", 1, "missing");
    ExpectFailure(folder, "bench none.gltf --json missing/b.json", 1, "missing");
    EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));
}

TEST(Program, MergeNeedsNoDevice) {
    const test::TemporaryFolder folder;
    session::WriteRenderFile(folder / "a.exr", test::MakeRender(0, 16));
    session::WriteRenderFile(folder / "b.exr", test::MakeRender(16, 48, 1.0f));
    session::WriteRenderFile(folder / "c.exr", test::MakeRender(63, 4));
    const ProgramResult merged = RunProgram(folder, "merge a.exr b.exr -o m.exr");
    EXPECT_EQ(merged.exitCode, 0) << merged.messages;
    EXPECT_NE(merged.output.find("64 samples"), std::string::npos) << merged.output;
    EXPECT_EQ(merged.messages, "");
    const std::string told = RunProgram(folder, "merge a.exr b.exr -o m.exr -v").messages;
    for (const char* text : {" a.exr: 16 samples of ", " b.exr: 48 samples of ", " m.exr: 64 samples of "})
        EXPECT_NE(told.find(text), std::string::npos) << told << "lacks" << text;
    EXPECT_EQ(session::ReadRenderFile(folder / "m.exr").samples, (session::SampleRanges{{0, 64}}));

    ExpectFailure(folder, "merge m.exr c.exr -o n.exr", 4, "m.exr", "c.exr", "0-63", "63-66");
    EXPECT_FALSE(std::filesystem::exists(folder / "n.exr"));
}

// Without --aov, the channels are those of the file.
TEST(Program, ChannelsOfAResumedRenderNeedAnExr) {
    const test::TemporaryFolder folder;
    session::WriteRenderFile(folder / "a.exr", test::MakeRender(0, 16));
    ExpectFailure(folder, "render @cornell.gltf --resume a.exr --spp 20 -o a.png", 2, "a.exr",
                  "albedo,normal,depth,instance,material");
    const ProgramResult result = RunProgram(folder, "render @cornell.gltf --resume a.exr --spp 20 -o a.png");
    EXPECT_EQ(result.messages.find("--aov"), std::string::npos) << result.messages;
}

TEST(Program, InfoOfASceneNeedsNoDevice) {
    const ProgramResult result = RunProgram(test::TemporaryFolder(), "info @cornell.gltf");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    for (const char* text : {"cornell.gltf", "triangles", "cameras", "materials", "emits"})
        EXPECT_NE(result.output.find(text), std::string::npos) << result.output << "lacks " << text;
}

}  // namespace
}  // namespace raygraph::program_usage_test
