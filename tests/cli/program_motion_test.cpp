// --at and --clips: what is shown, recorded and resumed.
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;

// The Cornell box, in which "rise" lifts the first node that has a mesh by 0.1 m a second, and "sink" lowers
// it.
void WriteBox(const test::TemporaryFolder& folder) {
    json scene = json::parse(std::ifstream(test::SceneFile("cornell.gltf")));
    // 0 and 1; (0, 0, 0) and (0, 0.1, 0); (0, 0, 0) and (0, -0.1, 0)
    const size_t buffer = scene["buffers"].size();
    scene["buffers"].push_back(
        {{"byteLength", 56},
         {"uri",
          "data:application/"
          "octet-stream;base64,AAAAAAAAgD8AAAAAAAAAAAAAAAAAAAAAzczMPQAAAAAAAAAAAAAAAAAAAAAAAAAAzc"
          "zMvQAAAAA="}});
    const size_t view = scene["bufferViews"].size();
    scene["bufferViews"].push_back({{"buffer", buffer}, {"byteLength", 56}});
    const size_t times = scene["accessors"].size();
    scene["accessors"].push_back({{"bufferView", view},
                                  {"componentType", 5126},
                                  {"count", 2},
                                  {"type", "SCALAR"},
                                  {"min", json::array({0})},
                                  {"max", json::array({1})}});
    size_t node = 0;
    while (!scene["nodes"][node].contains("mesh")) ++node;
    for (const size_t offset : {8, 32}) {
        scene["accessors"].push_back({{"bufferView", view},
                                      {"byteOffset", offset},
                                      {"componentType", 5126},
                                      {"count", 2},
                                      {"type", "VEC3"}});
        scene["animations"].push_back(
            {{"name", offset == 8 ? "rise" : "sink"},
             {"samplers", json::array({{{"input", times}, {"output", scene["accessors"].size() - 1}}})},
             {"channels",
              json::array({{{"sampler", 0}, {"target", {{"node", node}, {"path", "translation"}}}}})}});
    }
    std::ofstream(folder / "box.gltf") << scene;
}

TEST(ProgramMotion, InfoListsAnimations) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    const ProgramResult info = RunProgram(folder, "info box.gltf");
    EXPECT_EQ(info.exitCode, 0) << info.messages;
    EXPECT_NE(info.output.find("  animations  2\n    0  \"rise\"  1.0 s\n    1  \"sink\"  1.0 s\n"),
              std::string::npos)
        << info.output;
    EXPECT_EQ(RunProgram(folder, "info @cornell.gltf").output.find("animations"), std::string::npos);
}

TEST(ProgramMotion, WhatCannotPlayIsRefusedInALine) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    for (const char* command : {"render -o a.png", "bench", "graph"}) {
        const std::string line = std::string(command) + " box.gltf ";
        const ProgramResult unknown = RunProgram(folder, line + "--at 1 --clips fly");
        EXPECT_EQ(unknown.exitCode, 4) << command;
        EXPECT_EQ(unknown.messages,
                  "raygraph: --clips: there is no animation \"fly\"; the scene has 0 \"rise\", 1 \"sink\"\n");
        const ProgramResult timeless = RunProgram(folder, line + "--clips rise");
        EXPECT_EQ(timeless.exitCode, 2) << command;
        EXPECT_EQ(timeless.messages, "raygraph: --clips: animations play at a time, and none is given\n");
        EXPECT_EQ(RunProgram(folder, line + "--at soon").exitCode, 2) << command;
    }
}

TEST(ProgramMotion, TimesAreRenderedRecordedAndResumed) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    const auto render = [&](const std::string& options) {
        const ProgramResult result = RunProgram(folder, "render box.gltf --size 16x16 " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
    };
    render("--spp 2 -o rest.exr");
    render("--spp 2 --at 0 -o start.exr");
    render("--spp 2 --at 1 -o end.exr");
    render("--spp 2 --at 1 --clips sink -o sunk.exr");
    render("--spp 2 --at 1 --clips rise:0.5,sink:0.5 -o between.exr");
    render("--spp 4 --at 1 -o whole.exr");
    const auto read = [&](const char* name) { return session::ReadRenderFile(folder / name); };
    const session::RenderFile rest = read("rest.exr"), end = read("end.exr");
    EXPECT_EQ(read("start.exr").radiance, rest.radiance) << "at 0 s nothing has moved";
    EXPECT_NE(end.radiance, rest.radiance);
    EXPECT_NE(read("sunk.exr").radiance, rest.radiance);
    EXPECT_NE(read("sunk.exr").radiance, end.radiance);
    EXPECT_EQ(read("between.exr").radiance, rest.radiance) << "up as far as down";
    EXPECT_EQ(rest.settings.at("at"), "");
    EXPECT_EQ(end.settings.at("at"), "1");
    EXPECT_EQ(read("sunk.exr").settings.at("clips"), "sink");
    EXPECT_NE(end.sceneHash, rest.sceneHash);
    const ProgramResult more = RunProgram(folder, "render box.gltf --resume end.exr --spp 4 -o more.exr");
    EXPECT_EQ(more.exitCode, 0) << more.messages;
    EXPECT_EQ(read("more.exr").radiance, read("whole.exr").radiance);
    const ProgramResult other =
        RunProgram(folder, "render box.gltf --resume end.exr --at 2 --spp 4 -o x.exr");
    EXPECT_NE(other.exitCode, 0);
}

}  // namespace
}  // namespace raygraph
