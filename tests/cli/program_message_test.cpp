// Tests the messages of every command as its user sees them. It needs a device.
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::program_message_test {
namespace {

using test::EnvironmentVariable;
using test::ProgramResult;
using test::RunProgram;
using test::SceneFile;
using test::TextOf;

void ExpectHas(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text << "\n  lacks " << part;
}

void ExpectLacks(const std::string& text, const std::string& part) {
    EXPECT_EQ(text.find(part), std::string::npos) << text << "\n  has " << part;
}

// The place of the folder for pipeline caches has a file, so that the device warns.
class ProgramMessages : public ::testing::Test {
  protected:
    ProgramMessages() {
        std::ofstream(folder.Path() / "raygraph") << "no folder";
        nlohmann::json scene = nlohmann::json::parse(std::ifstream(SceneFile("cornell.gltf")));
        scene["extensionsUsed"] = {"EXT_unheard_of"};
        std::ofstream(folder / "warned.gltf") << scene;
    }

    test::TemporaryFolder folder;
    EnvironmentVariable cache{"XDG_CACHE_HOME", folder.Path().string()};
    const std::string deviceWarning = "raygraph: warning: pipeline cache is not saved: ";
    const std::string sceneWarning = "raygraph: warning: warned.gltf: extensionsUsed[0]: ";
};

TEST_F(ProgramMessages, WarningsOfSceneAndDeviceArriveFromRenderGraphAndBench) {
    for (const std::string line :
         {"render warned.gltf --size 16x16 --spp 1 -o a.png", "graph warned.gltf --first",
          "bench warned.gltf --size 16x16 --frames 1 --rounds 1"}) {
        const ProgramResult result = RunProgram(folder, line);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        ExpectHas(result.messages, deviceWarning);
        ExpectHas(result.messages, sceneWarning);
        ExpectLacks(result.messages, "raygraph: info: ");
        EXPECT_EQ(RunProgram(folder, line + " --quiet").messages, "") << line;
    }
}

TEST_F(ProgramMessages, WarningsArriveFromEdit) {
    std::ofstream(folder.Path() / "script.txt")
        << "size 120x100\nopen " << (folder / "warned.gltf").string() << "\nwait\nopen "
        << (folder / "none.gltf").string() << "\nwait\n";
    const ProgramResult result = RunProgram(folder, "edit --headless-script script.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(result);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    ExpectHas(result.messages, deviceWarning);
    ExpectHas(result.messages, sceneWarning);
    ExpectHas(result.messages, "none.gltf");
}

TEST_F(ProgramMessages, MoreIsSaidOnRequest) {
    const std::string line = "render @cornell.gltf --size 16x16 --spp 1 -o a.png";
    const auto messages = [&](const char* option) {
        const ProgramResult result = RunProgram(folder, line + option);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        return result.messages;
    };
    const std::string some = messages(" -v"), all = messages(" -vv");
    ExpectHas(some, "raygraph: info: [scene] cornell.gltf: ");
    ExpectHas(some, "raygraph: info: [device] device 'raygraph': ");
    ExpectHas(some, "uploaded in ");
    ExpectLacks(some, "raygraph: debug: ");
    ExpectHas(all, "raygraph: info: [scene] cornell.gltf: ");
    ExpectHas(all, "[shaders] pipeline of pathtrace/");
    ExpectHas(all, "raygraph: debug: [geometry] ");

    const EnvironmentVariable levels("RAYGRAPH_LOG", "error,geometry=debug");
    const ProgramResult chosen = RunProgram(folder, line);
    ExpectHas(chosen.messages, "raygraph: debug: [geometry] ");
    ExpectLacks(chosen.messages, "warning");
    ExpectLacks(chosen.messages, "[scene]");
}

TEST_F(ProgramMessages, EachImageOfASceneIsTimedOnRequest) {
    const ProgramResult result = RunProgram(folder, "info @texture_orientation.gltf -vv");
    ExpectHas(result.messages, "raygraph: debug: [scene] texture_orientation.gltf: images[0]");
    ExpectHas(result.messages, " PNG of ");
    ExpectLacks(RunProgram(folder, "info @texture_orientation.gltf -v").messages, " PNG of ");
}

TEST_F(ProgramMessages, GoIntoAFileAsWell) {
    const ProgramResult first = RunProgram(folder, "info warned.gltf --log a.log");
    EXPECT_EQ(first.exitCode, 0) << first.messages;
    ExpectHas(first.messages, sceneWarning);
    const std::string once = TextOf(folder.Path() / "a.log");
    ExpectHas(once, "warning scene      warned.gltf: extensionsUsed[0]: ");
    ExpectHas(once, "info    scene      warned.gltf: ");
    EXPECT_EQ(RunProgram(folder, "info none.gltf --log a.log").exitCode, 4);
    const std::string twice = TextOf(folder.Path() / "a.log");
    EXPECT_TRUE(twice.starts_with(once)) << "it is added to";
    ExpectHas(twice, "error   program    ");
    ExpectHas(twice, "none.gltf");
}

TEST_F(ProgramMessages, WhatCannotBeIsOneLine) {
    const auto expect = [&](const char* line, int exitCode, const std::string& part) {
        const ProgramResult result = RunProgram(folder, line);
        EXPECT_EQ(result.exitCode, exitCode) << result.messages;
        EXPECT_EQ(result.output, "");
        EXPECT_TRUE(result.messages.starts_with("raygraph: ")) << result.messages;
        EXPECT_EQ(result.messages.find('\n') + 1, result.messages.size()) << result.messages;
        ExpectHas(result.messages, part);
    };
    expect("info warned.gltf --log none/a.log", 1, "none");
    expect("info warned.gltf --log warned.gltf", 2, "to be read and to be written");
    expect("info warned.gltf --log ''", 2, "--log");
    expect("info warned.gltf --quiet -v", 2, "--quiet");
    const EnvironmentVariable levels("RAYGRAPH_LOG", "loud");
    expect("info warned.gltf", 4, "RAYGRAPH_LOG: \"loud\" is no level: debug, info, warning, error, off");
}

// A log is appended to as soon as it is opened, so it must be refused before.
TEST_F(ProgramMessages, LogIsNoFileThatTheCommandReadsOrWrites) {
    std::ofstream(folder / "kept") << "as it was";
    const auto expectRefused = [&](const std::string& line, const std::string& part) {
        const ProgramResult result = RunProgram(folder, line + " --log kept");
        EXPECT_EQ(result.exitCode, 2) << result.messages;
        ExpectHas(result.messages, part);
        EXPECT_EQ(TextOf(folder / "kept"), "as it was") << line;
    };
    expectRefused("render warned.gltf --env kept", "to be read and to be written");
    expectRefused("render warned.gltf --resume kept -o b.exr", "to be read and to be written");
    expectRefused("render warned.gltf --report kept", "written twice");
    expectRefused("bench warned.gltf --compare kept", "to be read and to be written");
    expectRefused("bench warned.gltf --json kept", "written twice");
    expectRefused("merge a.exr kept -o b.exr", "to be read and to be written");
    expectRefused("edit --headless-script kept", "to be read and to be written");

    std::ofstream(folder / "a.png") << "a picture";
    const ProgramResult picture = RunProgram(folder, "render warned.gltf -o a.png --log a.png");
    EXPECT_EQ(picture.exitCode, 2) << picture.messages;
    EXPECT_EQ(TextOf(folder / "a.png"), "a picture");
}

TEST_F(ProgramMessages, LogMayBeADevice) {
    const ProgramResult result =
        RunProgram(folder, "render warned.gltf -o a.png --size 8x8 --spp 1 --log /dev/null");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
}

}  // namespace
}  // namespace raygraph::program_message_test
