// Tests --points and --lines: what is shown, counted, recorded and refused.
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_points_test {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;

constexpr const char* kScene = "@points_and_lines.gltf";

TEST(ProgramPoints, InfoCountsThemAndWarnsOfThoseLeftOut) {
    const test::TemporaryFolder folder;
    const ProgramResult plain = RunProgram(folder, std::string("info ") + kScene);
    EXPECT_EQ(plain.exitCode, 0) << plain.messages;
    EXPECT_EQ(plain.output.find("points"), plain.output.find("points_and_lines.gltf")) << plain.output;
    EXPECT_NE(plain.messages.find("2500 points are left out; a radius (--points) shows them as spheres"),
              std::string::npos)
        << plain.messages;
    EXPECT_NE(
        plain.messages.find("432 line segments are left out; a radius (--lines) shows them as capsules"),
        std::string::npos)
        << plain.messages;
    const ProgramResult shown =
        RunProgram(folder, std::string("info ") + kScene + " --points 0.02 --lines 0.5%");
    EXPECT_EQ(shown.exitCode, 0);
    EXPECT_EQ(shown.messages, "");
    EXPECT_NE(shown.output.find("  points      2,500 placed\n  segments    432 placed\n"), std::string::npos)
        << shown.output;
}

TEST(ProgramPoints, WhatIsNoRadiusIsTwoAndABadFileIsFour) {
    const test::TemporaryFolder folder;
    for (const char* command : {"info ", "render -o a.png ", "bench ", "graph "}) {
        const ProgramResult result = RunProgram(folder, std::string(command) + kScene + " --points 0");
        EXPECT_EQ(result.exitCode, 2) << command;
        EXPECT_NE(result.messages.find("--points: \"0\" is not a radius"), std::string::npos)
            << result.messages;
    }
    EXPECT_EQ(RunProgram(folder, "info --devices --lines 1").exitCode, 2);
    json scene = json::parse(std::ifstream(test::SceneFile("points_and_lines.gltf")));
    for (json& accessor : scene["accessors"])
        if (accessor["type"] == "SCALAR" && accessor["count"] == 240) accessor["count"] = 241;
    std::ofstream(folder / "bad.gltf") << scene;
    const ProgramResult bad = RunProgram(folder, "info bad.gltf --lines 1");
    EXPECT_EQ(bad.exitCode, 4) << bad.messages;
    EXPECT_EQ(std::count(bad.messages.begin(), bad.messages.end(), '\n'), 1) << bad.messages;
}

TEST(ProgramPoints, RadiiAreSettingsOfARender) {
    const test::TemporaryFolder folder;
    const auto render = [&](const std::string& options) {
        const ProgramResult result = RunProgram(folder, std::string("render ") + kScene + " " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
    };
    render("--size 16x16 --spp 2 --points 0.05 --lines 1% -o two.exr");
    render("--size 16x16 --spp 4 --points 0.05 --lines 1% -o four.exr");
    const session::RenderFile two = session::ReadRenderFile(folder / "two.exr");
    EXPECT_EQ(two.settings.at("points"), "0.05");
    EXPECT_EQ(two.settings.at("lines"), "1%");
    render("--resume two.exr --spp 4 -o more.exr");
    EXPECT_EQ(session::ReadRenderFile(folder / "more.exr").radiance,
              session::ReadRenderFile(folder / "four.exr").radiance);
    EXPECT_EQ(RunProgram(folder,
                         std::string("render ") + kScene + " --resume two.exr --points 0.1 --spp 4 -o a.exr")
                  .exitCode,
              2);
}

}  // namespace
}  // namespace raygraph::program_points_test
