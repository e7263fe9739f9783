// Tests --progress as a script or a log file gets it. It needs a device.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_progress_test {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;

std::vector<std::string> Lines(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

// Reads messages as a script does: every line that begins with a brace is an object, the others are for
// people.
std::vector<json> Events(const std::string& messages) {
    std::vector<json> events;
    for (const std::string& line : Lines(messages))
        if (line.starts_with('{')) events.push_back(json::parse(line));
    return events;
}

TEST(ProgramProgress, AScriptFollowsARenderFromTheFileToThePictures) {
    const test::TemporaryFolder folder;
    const ProgramResult result =
        RunProgram(folder,
                   "render @cornell.gltf --size 16x16 --spp 5 --frames 0:0.5:0.5 -o a.##.png -o a.##.exr "
                   "--report a.##.json --progress json -v");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_NE(result.messages.find("raygraph: info: "), std::string::npos) << "messages stay lines of text";
    const std::vector<json> events = Events(result.messages);
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(events[0], json::parse(R"({"event": "loading", "stage": "file", "fraction": 0.0})"));

    for (const auto& [picture, number] : {std::pair{"frame 1 of 2", "00"}, std::pair{"frame 2 of 2", "01"}}) {
        std::vector<json> samples;
        json written;
        for (const json& event : events) {
            if (event.value("picture", "") != picture) continue;
            if (event["event"] == "progress") {
                EXPECT_TRUE(written.is_null()) << "files come last";
                EXPECT_EQ(event["samples_wanted"], 5);
                samples.push_back(event);
            }
            if (event["event"] == "written") written = event;
        }
        ASSERT_GE(samples.size(), 2u) << picture;
        EXPECT_LT(samples.front()["samples"], 5);
        EXPECT_EQ(samples.back()["samples"], 5);
        EXPECT_GT(samples.back()["samples_per_second"], 0.0);
        EXPECT_GT(samples.back()["relative_error"], 0.0);
        EXPECT_EQ(samples.back()["seconds_left"], 0.0);
        ASSERT_TRUE(written.is_object()) << picture;
        std::vector<std::string> files = written["files"];
        std::ranges::sort(files);
        EXPECT_EQ(files,
                  (std::vector{std::string("a.") + number + ".exr", std::string("a.") + number + ".json",
                               std::string("a.") + number + ".png"}));
        for (const std::string& file : files) EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
    }
    EXPECT_EQ(Events(result.output).size(), 0u) << "stdout is the summary for people";
    EXPECT_NE(result.output.find("5 samples a pixel"), std::string::npos) << result.output;
}

TEST(ProgramProgress, PlainIsLinesOfTextAndNoneIsWarningsAlone) {
    const test::TemporaryFolder folder;
    const std::string line = "render @cornell.gltf --size 16x16 --spp 3 -o a.png --background 0,0,0";
    const ProgramResult plain = RunProgram(folder, line + " --progress plain");
    ASSERT_EQ(plain.exitCode, 0) << plain.messages;
    EXPECT_EQ(plain.messages.find('\r'), std::string::npos) << "nothing is redrawn";
    const std::vector<std::string> lines = Lines(plain.messages);
    ASSERT_GE(lines.size(), 3u);
    EXPECT_EQ(lines[0], "raygraph: loading file, 0 %");
    EXPECT_EQ(lines.back().find("raygraph: 3/3 samples, "), 0u) << lines.back();
    for (const char* silent : {"", " --progress auto", " --progress none"})
        EXPECT_EQ(RunProgram(folder, line + silent).messages, "") << "stderr is no terminal";

    std::string shown;
    const ProgramResult none = test::RunProgramOnTerminal(
        folder, line + " --nee off --progress none", [&](pid_t, const std::string& text) { shown = text; });
    EXPECT_EQ(none.exitCode, 0);
    EXPECT_EQ(none.output.find("samples  "), std::string::npos) << none.output;
    EXPECT_EQ(none.output.find("loading"), std::string::npos) << none.output;
}

TEST(ProgramProgress, WarningsAreShownWithoutProgressAndTheErrorComesLast) {
    const test::TemporaryFolder folder;
    const ProgramResult dark = RunProgram(
        folder, "render @furnace_sphere.gltf --light none --size 8x8 --spp 1 -o a.png --progress none");
    EXPECT_NE(dark.messages.find("raygraph: warning: "), std::string::npos) << dark.messages;
    const ProgramResult failed = RunProgram(folder, "render @cornell.gltf --camera nobody --progress json");
    EXPECT_EQ(failed.exitCode, 2);
    const std::vector<std::string> lines = Lines(failed.messages);
    ASSERT_GE(lines.size(), 2u);
    EXPECT_TRUE(lines.front().starts_with('{'));
    EXPECT_EQ(lines.back().find("raygraph: --camera"), 0u) << failed.messages;
}

TEST(ProgramProgress, BenchTellsItsRounds) {
    const ProgramResult result = RunProgram(
        test::TemporaryFolder(), "bench @cornell.gltf --size 8x8 --frames 1 --rounds 2 --progress json");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    std::vector<std::string> steps;
    for (const json& event : Events(result.messages)) steps.push_back(event.at("step"));
    EXPECT_EQ(steps, (std::vector<std::string>{"warming up", "round 1/2", "round 2/2", "counting rays"}));
}

TEST(ProgramProgress, QuietIsNoPlaceForLines) {
    for (const char* command : {"render", "bench"})
        for (const char* style : {"plain", "json"}) {
            const ProgramResult result = RunProgram(
                test::TemporaryFolder(), std::string(command) + " none.gltf --quiet --progress " + style);
            EXPECT_EQ(result.exitCode, 2);
            EXPECT_EQ(result.messages,
                      std::string("raygraph: --quiet and --progress ") + style + " exclude each other\n");
        }
    EXPECT_EQ(RunProgram(test::TemporaryFolder(), "render none.gltf --quiet --progress none").exitCode, 4);
}

}  // namespace
}  // namespace raygraph::program_progress_test
