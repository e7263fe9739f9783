// Tests --at and --clips: what is shown, recorded and resumed.
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/animated_box.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_motion_test {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;
using test::WriteBox;

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

// The box at rest needs no keys, and the keys of the other animation are valid.
TEST(ProgramMotion, BrokenKeysAreAnErrorOfTheAnimationThatPlays) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    json scene = json::parse(std::ifstream(folder / "box.gltf"));
    const size_t output = scene["animations"][0]["samplers"][0]["output"];
    scene["accessors"][output]["count"] = 1;
    std::ofstream(folder / "box.gltf") << scene;
    const std::string line = "box.gltf: animations[0].samplers[0].output: accessors[" +
                             std::to_string(output) + "] has 1 element, must have 2 for 2 keys of LINEAR";
    const ProgramResult info = RunProgram(folder, "info box.gltf");
    EXPECT_EQ(info.exitCode, 0);
    EXPECT_NE(info.messages.find(line + "; the animation cannot be played"), std::string::npos)
        << info.messages;
    for (const char* command : {"render -o a.png", "bench", "graph"})
        for (const char* clips : {"", " --clips rise", " --clips all"}) {
            const ProgramResult refused =
                RunProgram(folder, std::string(command) + " box.gltf --at 1" + clips);
            EXPECT_EQ(refused.exitCode, 4) << command << clips;
            EXPECT_EQ(refused.messages, "raygraph: " + line + "\n");
        }
    EXPECT_EQ(RunProgram(folder, "graph box.gltf --at 1 --clips sink").exitCode, 0);
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
    EXPECT_EQ(end.sceneHash, rest.sceneHash) << "the same file, whatever it shows";
    const ProgramResult more = RunProgram(folder, "render box.gltf --resume end.exr --spp 4 -o more.exr");
    EXPECT_EQ(more.exitCode, 0) << more.messages;
    EXPECT_EQ(read("more.exr").radiance, read("whole.exr").radiance);
    const ProgramResult other =
        RunProgram(folder, "render box.gltf --resume end.exr --at 2 --spp 4 -o x.exr");
    EXPECT_NE(other.exitCode, 0);
}

TEST(ProgramMotion, FramesAreThePicturesOfTheirTimes) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    const ProgramResult frames = RunProgram(
        folder, "render box.gltf --size 16x16 --spp 2 --frames 0.5:1:0.25 -o f.##.exr -o f.##.png");
    EXPECT_EQ(frames.exitCode, 0) << frames.messages;
    EXPECT_NE(frames.output.find("f.02.exr\nf.02.png\n2 samples a pixel"), std::string::npos)
        << frames.output;
    const auto read = [&](const char* name) { return session::ReadRenderFile(folder / name); };
    for (const auto& [name, at] : {std::pair("f.02.exr", "0.5"), {"f.03.exr", "0.75"}, {"f.04.exr", "1"}}) {
        const ProgramResult still =
            RunProgram(folder, std::string("render box.gltf --size 16x16 --spp 2 -o still.exr --at ") + at);
        EXPECT_EQ(still.exitCode, 0) << still.messages;
        EXPECT_EQ(read(name).radiance, read("still.exr").radiance) << at;
        EXPECT_EQ(read(name).settings, read("still.exr").settings) << at;
        EXPECT_EQ(read(name).samples, read("still.exr").samples) << at;
    }
    EXPECT_NE(read("f.02.exr").radiance, read("f.04.exr").radiance);
    EXPECT_TRUE(std::filesystem::exists(folder / "f.04.png"));
    EXPECT_FALSE(std::filesystem::exists(folder / "f.05.exr"));
    const ProgramResult more = RunProgram(folder, "render box.gltf --resume f.03.exr --spp 4 -o more.exr");
    EXPECT_EQ(more.exitCode, 0) << more.messages;
}

// Each frame has one sample, so the current one completes, and the next is not begun.
TEST(ProgramMotion, AnInterruptEndsASequenceAfterTheFrameThatIsBegun) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    bool isSent = false;
    const ProgramResult result = test::RunProgramOnTerminal(
        folder, "render box.gltf --size 16x16 --spp 1 --frames 0:99:0.001 -o f.#####.png",
        [&](pid_t process, const std::string& shown) {
            if (isSent || shown.find("f.00001.png") == std::string::npos) return;
            isSent = true;
            kill(process, SIGINT);
        });
    EXPECT_EQ(result.exitCode, 0) << result.output;
    const size_t files =
        size_t(std::ranges::count_if(std::filesystem::directory_iterator(folder.Path()),
                                     [](const auto& entry) { return entry.path().extension() == ".png"; }));
    EXPECT_GE(files, 2u);
    EXPECT_LT(files, 99000u);
    const std::string left = std::to_string(99001 - files) + " of 99001 pictures were not begun";
    EXPECT_NE(result.output.find(left), std::string::npos)
        << files << " files, " << result.output.substr(result.output.size() - 300);
}

TEST(ProgramMotion, FramesThatCannotBeAreRefusedBeforeAnyIsRendered) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    const auto refused = [&](const std::string& options, const char* part) {
        const ProgramResult result = RunProgram(folder, "render box.gltf " + options);
        EXPECT_EQ(result.exitCode, 2) << options;
        EXPECT_NE(result.messages.find(part), std::string::npos) << result.messages;
    };
    refused("--frames 0:1:0.5 -o a.png", "\"a.png\" has no single run of # for the numbers of --frames");
    refused("--frames 0:1:0.5 -o a.#.png --report r.json", "\"r.json\" has no single run of #");
    refused("--frames 0:1:0.5 -o a.#.png --at 1", "--frames and --at exclude each other");
    refused("--frames 0:1:0.5 -o a.#.exr --resume a.#.exr", "--resume goes on with one");
    refused("--frames 1:0:0.5 -o a.#.png", "--frames: \"1:0:0.5\" ends before it begins");
    refused("--shutter 0:1 -o a.png", "--shutter: it is around a time, and none is given");
    refused("--at 0 --shutter 1:0 -o a.png", "--shutter: \"1:0\": a shutter closes after it opens");
    refused("--at 0 --shutter 0.5 -o a.png", "--shutter: \"0.5\" is not OPEN:CLOSE");
    refused("--at 0 --shutter 0:1 --view material -o a.png",
            "--shutter: the view material is not averaged over samples");
}

TEST(ProgramMotion, ShutterBlursAndIsResumed) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    const auto render = [&](const std::string& options) {
        const ProgramResult result =
            RunProgram(folder, "render box.gltf --size 16x16 --background 1,1,1 " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
    };
    render("--spp 4 --at 0 --shutter 0:1 -o whole.exr");
    render("--spp 2 --at 0 --shutter 0:1 -o half.exr");
    render("--resume half.exr --spp 4 -o resumed.exr");
    render("--spp 2 --at 0 --shutter 0:1 --sample-offset 2 -o other.exr");
    render("--spp 4 --at 0 -o sharp.exr");
    const ProgramResult merged = RunProgram(folder, "merge half.exr other.exr -o merged.exr");
    EXPECT_EQ(merged.exitCode, 0) << merged.messages;
    const auto read = [&](const char* name) { return session::ReadRenderFile(folder / name); };
    EXPECT_EQ(read("resumed.exr").radiance, read("whole.exr").radiance);
    EXPECT_EQ(read("merged.exr").radiance, read("whole.exr").radiance);
    EXPECT_NE(read("sharp.exr").radiance, read("whole.exr").radiance);
    EXPECT_EQ(read("whole.exr").settings.at("shutter"), "0:1");
    EXPECT_EQ(read("sharp.exr").settings.at("shutter"), "none");
}

}  // namespace
}  // namespace raygraph::program_motion_test
