// Tests --variant: what is shown, recorded and resumed.
#include <fstream>
#include <nlohmann/json.hpp>

#include "editor/session/file/content_hash.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_variant_test {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;

// Writes the Cornell box with variants that paint everything but the lamp: "paint" uses the material `paint`.
void WriteBox(const test::TemporaryFolder& folder, uint32_t paint) {
    json scene = json::parse(std::ifstream(test::SceneFile("cornell.gltf")));
    scene["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "paint"}}, {{"name", "other"}}};
    for (json& mesh : scene["meshes"])
        for (json& primitive : mesh["primitives"])
            if (scene["materials"][primitive["material"].get<size_t>()]["name"] != "lamp")
                primitive["extensions"]["KHR_materials_variants"]["mappings"] = {
                    {{"material", paint}, {"variants", {0}}}, {{"material", 1 - paint}, {"variants", {1}}}};
    std::ofstream(folder / "box.gltf") << scene;
}

TEST(ProgramVariant, InfoListsThemAndMarksTheOneThatIsShown) {
    const test::TemporaryFolder folder;
    WriteBox(folder, 0);
    const ProgramResult plain = RunProgram(folder, "info box.gltf");
    EXPECT_EQ(plain.exitCode, 0) << plain.messages;
    EXPECT_NE(plain.output.find("  variants    2\n    0  \"paint\"\n    1  \"other\"\n"), std::string::npos)
        << plain.output;
    const ProgramResult shown = RunProgram(folder, "info box.gltf --variant other");
    EXPECT_EQ(shown.exitCode, 0) << shown.messages;
    EXPECT_NE(shown.output.find("    0  \"paint\"\n    1  \"other\"  shown\n"), std::string::npos)
        << shown.output;
    EXPECT_EQ(RunProgram(folder, "info @cornell.gltf").output.find("variants"), std::string::npos);
}

TEST(ProgramVariant, OneThatIsNotThereIsFourWithALineThatNamesWhatThereIs) {
    const test::TemporaryFolder folder;
    WriteBox(folder, 0);
    for (const char* command : {"info", "render -o a.png", "bench", "graph"}) {
        const std::string line = std::string(command) + " box.gltf --variant ";
        const ProgramResult unknown = RunProgram(folder, line + "red");
        EXPECT_EQ(unknown.exitCode, 4) << command;
        EXPECT_EQ(
            unknown.messages,
            "raygraph: --variant: there is no variant \"red\"; the scene has 0 \"paint\", 1 \"other\"\n");
        EXPECT_EQ(RunProgram(folder, line + "2").exitCode, 4) << command;
    }
    const ProgramResult none = RunProgram(folder, "info @cornell.gltf --variant red");
    EXPECT_EQ(none.messages, "raygraph: --variant: there is no variant \"red\"; the scene has no variants\n");
    for (const char* line : {"edit --variant red", "info --devices --variant red"})
        EXPECT_EQ(RunProgram(folder, line).exitCode, 2) << line;
}

TEST(ProgramVariant, IsRenderedAndResumedAsItself) {
    const test::TemporaryFolder folder;
    WriteBox(folder, 0);
    const auto render = [&](const std::string& options) {
        const ProgramResult result = RunProgram(folder, "render box.gltf " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
    };
    render("--size 16x16 --spp 2 -o plain.exr");
    render("--size 16x16 --spp 2 --variant paint -o paint.exr");
    render("--size 16x16 --spp 4 --variant paint -o whole.exr");
    const session::RenderFile plain = session::ReadRenderFile(folder / "plain.exr");
    const session::RenderFile paint = session::ReadRenderFile(folder / "paint.exr");
    EXPECT_NE(plain.radiance, paint.radiance);
    EXPECT_NE(plain.sceneHash, paint.sceneHash);
    EXPECT_EQ(plain.settings.at("variant"), "");
    EXPECT_EQ(paint.settings.at("variant"), "paint");
    EXPECT_EQ(session::FirstMismatch(plain, paint).find("variant: "), 0u);

    render("--resume paint.exr --spp 4 -o more.exr");
    EXPECT_EQ(session::ReadRenderFile(folder / "more.exr").radiance,
              session::ReadRenderFile(folder / "whole.exr").radiance);
    const ProgramResult other =
        RunProgram(folder, "render box.gltf --resume paint.exr --variant other --spp 4 -o more.exr");
    EXPECT_NE(other.exitCode, 0);
    EXPECT_NE(other.messages.find("--variant"), std::string::npos) << other.messages;
    // The variant keeps its name, but has another material
    WriteBox(folder, 1);
    const ProgramResult changed =
        RunProgram(folder, "render box.gltf --resume paint.exr --spp 4 -o more.exr");
    EXPECT_EQ(changed.exitCode, 4);
    EXPECT_NE(changed.messages.find("the content of box.gltf has changed"), std::string::npos)
        << changed.messages;
}

TEST(ProgramVariant, EditOpensInIt) {
    const test::TemporaryFolder folder;
    WriteBox(folder, 0);
    std::ofstream(folder.Path() / "script.txt") << "size 120x100\nwait\nexpect variant other\n";
    const std::string line = "edit box.gltf --headless-script script.txt --variant ";
    const ProgramResult edited = RunProgram(folder, line + "other");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    EXPECT_EQ(edited.exitCode, 0) << edited.messages;
    std::ofstream(folder.Path() / "script.txt") << "wait\nexpect message there is no variant \"red\"\n";
    EXPECT_EQ(RunProgram(folder, line + "red").exitCode, 0) << "the editor stays open and says so";
}

}  // namespace
}  // namespace raygraph::program_variant_test
