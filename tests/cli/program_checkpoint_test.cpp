// Tests renders that are saved while they run, ended by signals, and resumed. It needs a device.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::program_checkpoint_test {
namespace {

using test::ProgramResult;
using test::RunProgram;
using test::RunProgramBeside;
using test::TemporaryFolder;
using test::TextOf;

std::string RunWell(const TemporaryFolder& folder, const std::string& line) {
    const ProgramResult result = RunProgram(folder, line);
    EXPECT_EQ(result.exitCode, 0) << line << "\n" << result.messages;
    return result.output;
}

uint64_t SamplesIn(const std::filesystem::path& path) {
    return session::SampleCount(session::ReadRenderFile(path).samples);
}

constexpr const char* kSmall = "render @cornell.gltf --size 16x16 ";
// This render would take hours.
constexpr const char* kEndless = "render @cornell.gltf --size 16x16 --spp 100000000 --progress plain ";

// Runs `line`, and sends the signal once it shows that it renders.
ProgramResult RunUntil(const TemporaryFolder& folder, const std::string& line, int signal) {
    bool isSent = false;
    return RunProgramBeside(folder, line, [&](pid_t process, const std::string& messages) {
        if (isSent || messages.find(" samples") == std::string::npos) return;
        isSent = true;
        kill(process, signal);
    });
}

void ExpectRefused(const TemporaryFolder& folder, const std::string& options, int exitCode,
                   const std::string& text) {
    const ProgramResult result = RunProgram(folder, "render @cornell.gltf " + options);
    EXPECT_EQ(result.exitCode, exitCode) << options;
    EXPECT_NE(result.messages.find(text), std::string::npos) << options << "\n" << result.messages;
    EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
}

TEST(ProgramCheckpoint, TheSameLineAfterAKillGivesTheBitsOfOneRun) {
    // Increase the samples until a checkpoint comes before the end, however fast the device is
    for (uint32_t samples = 150;; samples *= 4) {
        ASSERT_LT(samples, 10'000'000u) << "no checkpoint was written";
        const TemporaryFolder folder;
        const std::string options = Text("{}--spp {} --aov albedo,depth ", kSmall, samples);
        const std::string line = options + "--checkpoint 0.001 --resume a.exr -o a.exr -o a.png";
        const ProgramResult killed = RunProgramBeside(folder, line, [&](pid_t process, const std::string&) {
            if (std::filesystem::exists(folder / "a.exr")) kill(process, SIGKILL);
        });
        if (killed.exitCode == 0) continue;  // the render ended before the signal
        ASSERT_EQ(killed.exitCode, -1) << killed.messages;
        const uint64_t saved = SamplesIn(folder / "a.exr");
        if (saved == samples) continue;
        ASSERT_LT(saved, samples);
        EXPECT_NE(RunWell(folder, line).find(Text("{} of them new", samples - saved)), std::string::npos);
        RunWell(folder, options + "-o whole.exr -o whole.png");
        EXPECT_EQ(TextOf(folder / "a.exr"), TextOf(folder / "whole.exr"));
        EXPECT_EQ(TextOf(folder / "a.png"), TextOf(folder / "whole.png"));
        return;
    }
}

TEST(ProgramCheckpoint, WhoIsToldToEndSavesAndSaysTryAgain) {
    for (const int signal : {SIGTERM, SIGUSR2}) {
        SCOPED_TRACE(signal);
        const TemporaryFolder folder;
        const ProgramResult told =
            RunUntil(folder, std::string(kEndless) + "-o a.exr -o a.png --report a.json", signal);
        EXPECT_EQ(told.exitCode, 75) << told.messages;
        const uint64_t samples = SamplesIn(folder / "a.exr");
        ASSERT_GE(samples, 1u);
        EXPECT_NE(told.messages.find(Text("stopped after {} of 100000000 samples", samples)),
                  std::string::npos)
            << told.messages;
        EXPECT_TRUE(std::filesystem::exists(folder / "a.json"));
        RunWell(folder, Text("{}--spp {} -o whole.exr -o whole.png", kSmall, samples));
        EXPECT_EQ(TextOf(folder / "a.exr"), TextOf(folder / "whole.exr"));
        EXPECT_EQ(TextOf(folder / "a.png"), TextOf(folder / "whole.png"));
        RunWell(folder, Text("render @cornell.gltf --resume a.exr --spp {}", samples + 3));
        RunWell(folder, Text("{}--spp {} -o whole.exr", kSmall, samples + 3));
        EXPECT_EQ(TextOf(folder / "a.exr"), TextOf(folder / "whole.exr"));
    }
}

// Ctrl-C ends a render with checkpoints as it ends any other.
TEST(ProgramCheckpoint, ASaveOnDemandDoesNotEndTheRender) {
    const TemporaryFolder folder;
    bool isAsked = false, isCopied = false;
    const ProgramResult result =
        RunProgramBeside(folder, std::string(kEndless) + "--checkpoint 60 -o a.exr",
                         [&](pid_t process, const std::string& messages) {
                             if (!isAsked && messages.find(" samples") != std::string::npos) {
                                 isAsked = true;
                                 kill(process, SIGUSR1);
                             }
                             if (isCopied || !std::filesystem::exists(folder / "a.exr")) return;
                             std::filesystem::copy_file(folder / "a.exr", folder / "saved.exr");
                             isCopied = true;
                             kill(process, SIGINT);
                         });
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    ASSERT_TRUE(isCopied);
    const uint64_t saved = SamplesIn(folder / "saved.exr"), samples = SamplesIn(folder / "a.exr");
    EXPECT_GT(samples, saved);
    for (const auto& [name, count] : {std::pair{"saved.exr", saved}, std::pair{"a.exr", samples}}) {
        RunWell(folder, Text("{}--spp {} -o whole.exr", kSmall, count));
        EXPECT_EQ(TextOf(folder / name), TextOf(folder / "whole.exr")) << name;
    }
}

// Counts in the output of `--progress json` how often files were written.
size_t TimesWritten(const std::string& messages) {
    const std::string event = R"({"event":"written")";
    size_t count = 0;
    for (size_t at = messages.find(event); at != std::string::npos; at = messages.find(event, at + 1))
        ++count;
    return count;
}

TEST(ProgramCheckpoint, MinutesAreNoSeconds) {
    const TemporaryFolder folder;
    const ProgramResult result = RunProgram(
        folder, "render @cornell.gltf --size 16x16 --time 1.5 --checkpoint 1 -o a.exr --progress json");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_EQ(TimesWritten(result.messages), 1u) << result.messages;
}

TEST(ProgramCheckpoint, ATimeLimitIsOfAllThatIsRenderedBetweenCheckpoints) {
    const TemporaryFolder folder;
    // Compile first: that would exceed the time
    ASSERT_EQ(RunProgram(folder, "render @cornell.gltf --size 16x16 --spp 1 -o a.exr").exitCode, 0);
    const ProgramResult result = RunProgram(folder,
                                            "render @cornell.gltf --size 16x16 --time 1.5 --checkpoint 0.002 "
                                            "-o a.exr --report a.json --progress json");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_GT(TimesWritten(result.messages), 2u) << result.messages;
    const auto report = nlohmann::json::parse(TextOf(folder / "a.json"));
    EXPECT_GE(report.at("timings_ms").at("render"), 1500.0);
    EXPECT_EQ(report.at("samples"), SamplesIn(folder / "a.exr"));
    EXPECT_EQ(report.at("stopped"), false);
}

// A folder is in the way when the first checkpoint is due.
TEST(ProgramCheckpoint, WhatCannotBeSavedNowIsSavedLater) {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder / "a.exr";
    bool isBlocked = false, isFreed = false, isTold = false;
    const ProgramResult result = RunProgramBeside(
        folder, std::string(kEndless) + "--checkpoint 0.001 -o a.exr",
        [&](pid_t process, const std::string& messages) {
            std::error_code ignored;
            if (!isBlocked && messages.find("loading") != std::string::npos)
                isBlocked = std::filesystem::create_directory(file, ignored);
            if (isBlocked && !isFreed && messages.find("rendering goes on") != std::string::npos)
                isFreed = std::filesystem::remove(file);
            if (isTold || !std::filesystem::is_regular_file(file, ignored)) return;
            isTold = true;
            kill(process, SIGTERM);
        });
    EXPECT_TRUE(isBlocked && isFreed) << result.messages;
    EXPECT_EQ(result.exitCode, 75) << result.messages;
    EXPECT_NE(result.messages.find("not saved, rendering goes on: a.exr: "), std::string::npos)
        << result.messages;
    EXPECT_GE(SamplesIn(file), 1u);
}

// Wherever the program is killed, the file that can be resumed exists.
TEST(ProgramCheckpoint, TheRenderIsWrittenBeforeItsPictures) {
    const TemporaryFolder folder;
    RunWell(folder, "render @cornell.gltf --size 400x400 --spp 1 -o a.exr -o a.png -o a.hdr");
    const auto written = [&](const char* name) { return std::filesystem::last_write_time(folder / name); };
    EXPECT_LE(written("a.exr"), written("a.png"));
    EXPECT_LE(written("a.exr"), written("a.hdr"));
}

TEST(ProgramCheckpoint, ACompleteFileIsLeftAsItIs) {
    const TemporaryFolder folder;
    const std::string line = std::string(kSmall) + "--spp 4 --checkpoint 60 --resume a.exr -o a.exr -o a.png";
    RunWell(folder, line);
    const std::string exr = TextOf(folder / "a.exr");
    const auto old = std::filesystem::file_time_type::clock::now() - std::chrono::hours(1);
    for (const char* name : {"a.exr", "a.png"}) std::filesystem::last_write_time(folder / name, old);
    const ProgramResult again = RunProgram(folder, line);
    EXPECT_EQ(again.exitCode, 0);
    EXPECT_EQ(again.output, "a.exr is complete: 4 samples a pixel\n");
    EXPECT_EQ(again.messages, "");
    for (const char* name : {"a.exr", "a.png"})
        EXPECT_EQ(std::filesystem::last_write_time(folder / name), old) << name;
    EXPECT_EQ(RunWell(folder, line + " --quiet"), "");

    // Pictures with fewer samples, of an earlier checkpoint or never asked for before, are written again
    const std::string png = TextOf(folder / "a.png");
    std::ofstream(folder / "a.png") << "of fewer samples";
    std::filesystem::last_write_time(folder / "a.png", old - std::chrono::seconds(1));
    const std::string said = RunWell(folder, line + " -o b.png");
    EXPECT_NE(said.find("4 samples a pixel, 0 of them new"), std::string::npos) << said;
    for (const char* name : {"a.png", "b.png"}) EXPECT_EQ(TextOf(folder / name), png) << name;
    EXPECT_EQ(std::filesystem::last_write_time(folder / "a.exr"), old);
    EXPECT_EQ(TextOf(folder / "a.exr"), exr);

    RunWell(folder, std::string(kSmall) + "--spp 6 --checkpoint 60 --resume a.exr -o a.exr -o a.png");
    RunWell(folder, std::string(kSmall) + "--spp 6 -o whole.exr");
    EXPECT_EQ(TextOf(folder / "a.exr"), TextOf(folder / "whole.exr"));
}

TEST(ProgramCheckpoint, WhileItLoadsATerminatedRenderEndsAtOnce) {
    // If loading ended before the signal came, the render was saved, so the test tries again
    for (int attempt = 0; attempt < 10; ++attempt) {
        const TemporaryFolder folder;
        std::ofstream(folder / "a.exr") << "old";
        bool isSent = false;
        const ProgramResult result = RunProgramBeside(
            folder, std::string(kEndless) + "-o a.exr", [&](pid_t process, const std::string& messages) {
                if (isSent || messages.find("loading") == std::string::npos) return;
                isSent = true;
                kill(process, SIGTERM);
            });
        EXPECT_EQ(result.exitCode, 75);
        if (TextOf(folder / "a.exr") != "old") continue;
        EXPECT_EQ(result.messages.find("stopped after"), std::string::npos) << result.messages;
        EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.Path()), {}), 1);
        return;
    }
    FAIL() << "the file was always replaced";
}

TEST(ProgramCheckpoint, OfASequenceWhatIsThereIsNotRenderedAgain) {
    const TemporaryFolder folder, whole;
    const std::string line = std::string(kSmall) + "--spp 6 --frames 0:0.08:0.04 -o f.#.exr ";
    RunWell(whole, line);
    RunWell(folder, std::string(kSmall) + "--spp 6 --at 0 -o f.0.exr");
    RunWell(folder, std::string(kSmall) + "--spp 2 --at 0.04 -o f.1.exr");
    const auto old = std::filesystem::file_time_type::clock::now() - std::chrono::hours(1);
    std::filesystem::last_write_time(folder / "f.0.exr", old);
    const std::string said = RunWell(folder, line + "--checkpoint 60 --resume f.#.exr");
    EXPECT_EQ(said.find("f.0.exr is complete: 6 samples a pixel\nf.1.exr\n"), 0u) << said;
    EXPECT_NE(said.find("6 samples a pixel, 4 of them new"), std::string::npos) << said;
    EXPECT_EQ(std::filesystem::last_write_time(folder / "f.0.exr"), old);
    for (const char* name : {"f.0.exr", "f.1.exr", "f.2.exr"})
        EXPECT_EQ(TextOf(folder / name), TextOf(whole / name)) << name;
}

// Checkpoints do not change this: half of a sequence would otherwise be of the old options.
TEST(ProgramCheckpoint, ACompleteFileOfAnotherPictureIsNotWhatIsAskedFor) {
    const TemporaryFolder folder;
    const std::string frames = "--size 8x6 --frames 0:0.04:0.04 --checkpoint 60 --resume f.#.exr -o f.#.exr ";
    RunWell(folder, "render @cornell.gltf --spp 1 " + frames);
    const auto refuse = [&](const std::string& options, const std::string& difference) {
        ExpectRefused(
            folder, options, 4,
            "f.0.exr is complete, but another picture than the one that is asked for: " + difference);
    };
    refuse(frames + "--spp 1 --seed 5", "seed: 0 against 5");
    refuse(frames + "--spp 1 --aov depth", "its channels");
    refuse(frames + "--spp 1 --sample-offset 7", "first sample: 0 against 7");
    const ProgramResult other =
        RunProgram(folder,
                   "render @terrace.gltf --size 8x6 --at 0 --spp 1 --checkpoint 60 --resume f.0.exr "
                   "-o f.0.exr");
    EXPECT_EQ(other.exitCode, 4);
    EXPECT_NE(other.messages.find("scene: cornell.gltf against terrace.gltf"), std::string::npos)
        << other.messages;
    RunWell(folder, "render @cornell.gltf --spp 1 " + frames);
}

TEST(ProgramCheckpoint, ASequenceEndsWithTheFrameOfTheSignal) {
    const TemporaryFolder folder;
    const ProgramResult result =
        RunUntil(folder, std::string(kEndless) + "--frames 0:0.08:0.04 --checkpoint 60 -o f.#.exr", SIGHUP);
    EXPECT_EQ(result.exitCode, 75);
    EXPECT_NE(result.messages.find("2 of 3 pictures were not begun"), std::string::npos) << result.messages;
    EXPECT_GE(SamplesIn(folder / "f.0.exr"), 1u);
    EXPECT_FALSE(std::filesystem::exists(folder / "f.1.exr"));
}

TEST(ProgramCheckpoint, ARenderToAnErrorEndsAtTheSameSample) {
    const TemporaryFolder folder;
    const std::string options = "render @cornell.gltf --size 12x12 --error 0.35 ";
    RunWell(folder, options + "-o whole.exr");
    const uint64_t wanted = SamplesIn(folder / "whole.exr");
    ASSERT_GT(wanted, 65u);
    // Stops once after the first measurement, and wherever the signals come
    RunWell(folder, options + "--spp 65 -o a.exr");
    const std::string line = options + "--checkpoint 0.001 --resume a.exr -o a.exr --progress plain";
    for (int i = 0; i < 3; ++i) {
        const int code = RunUntil(folder, line, SIGUSR2).exitCode;
        EXPECT_TRUE(code == 75 || code == 0) << code;
    }
    RunWell(folder, line);
    EXPECT_EQ(SamplesIn(folder / "a.exr"), wanted);
    EXPECT_EQ(TextOf(folder / "a.exr"), TextOf(folder / "whole.exr"));
    EXPECT_EQ(RunWell(folder, line), Text("a.exr is complete: {} samples a pixel\n", wanted));
}

TEST(ProgramCheckpoint, WhatCannotBeSavedOrGoneOnWithIsRefused) {
    const TemporaryFolder folder;
    ExpectRefused(folder, "--checkpoint 1 -o a.png", 2, "--checkpoint saves renders that can be resumed");
    ExpectRefused(folder, "--checkpoint 1 -o a.exr --exr-type half", 2, "leaves out their sums");
    ExpectRefused(folder, "--checkpoint 0 -o a.exr", 2, "--checkpoint: \"0\"");
    ExpectRefused(folder, "--frames 0:1:1 --resume f.#.exr -o f.#.exr", 2, "only with --checkpoint");
    ExpectRefused(folder, "--time 1 --checkpoint 1 --resume f.exr -o f.exr", 2, "is never complete");
    ExpectRefused(folder, "--frames 0:1:1 --checkpoint 1 --resume f.exr -o f.#.exr", 2,
                  "\"f.exr\" has no single run of #");
    ExpectRefused(folder, "--resume a.exr -o a.exr --spp 8", 4, "a.exr");
    EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));

    RunWell(folder, std::string(kSmall) + "--spp 2 -o a.exr");
    const std::string before = TextOf(folder / "a.exr");
    const std::string again = "--checkpoint 1 --resume a.exr -o a.exr --spp 8 ";
    ExpectRefused(folder, again + "--seed 4", 2, "--seed 4: a.exr was rendered with 0");
    const ProgramResult other = RunProgram(folder, "render @furnace_row.gltf " + again + "--size 16x16");
    EXPECT_EQ(other.exitCode, 4) << other.messages;
    EXPECT_NE(other.messages.find("a.exr cannot be resumed"), std::string::npos) << other.messages;
    EXPECT_EQ(TextOf(folder / "a.exr"), before);
    std::ofstream(folder / "a.exr") << "no render";
    ExpectRefused(folder, again, 4, "a.exr");
    EXPECT_EQ(TextOf(folder / "a.exr"), "no render");
}

}  // namespace
}  // namespace raygraph::program_checkpoint_test
