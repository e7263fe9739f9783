// Tests what the program does if an output cannot be written: files, stdout, stderr. It needs a device.
#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "base/text.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::program_outputs_test {
namespace {

using test::ProgramResult;
using test::RunProgram;
using test::RunProgramBeside;
using test::TemporaryFolder;
using test::TextOf;

constexpr const char* kTiny = "render @cornell.gltf --view albedo --size 8x8 --spp 1 ";
// This render would take minutes.
constexpr const char* kEndless = "render @cornell.gltf --brdf lambert --nee off --size 16x16 --time 200 ";

// Runs `line` while a folder takes the place of a file once its outputs have been checked.
ProgramResult RunBlocked(const TemporaryFolder& folder, const std::string& line, const char* blocked,
                         const std::function<void(pid_t, const std::string&)>& meanwhile = {}) {
    bool isBlocked = false;
    const ProgramResult result =
        RunProgramBeside(folder, line + " --progress plain", [&](pid_t process, const std::string& messages) {
            if (!isBlocked && messages.find("loading") != std::string::npos)
                isBlocked = std::filesystem::create_directory(folder / blocked);
            if (meanwhile) meanwhile(process, messages);
        });
    EXPECT_TRUE(isBlocked) << result.messages;
    return result;
}

ProgramResult RunPrepared(const TemporaryFolder& folder, const std::string& line,
                          const std::function<void()>& prepare) {
    return RunProgramBeside(
        folder, line, [](pid_t, const std::string&) {}, prepare);
}

TEST(ProgramOutputs, OneThatCannotBeWrittenLosesNoOther) {
    const TemporaryFolder folder;
    const ProgramResult result =
        RunBlocked(folder, std::string(kTiny) + "-o a.png -o a.exr -o b.png --report a.json", "a.png");
    EXPECT_EQ(result.exitCode, 1);
    EXPECT_NE(result.messages.find("raygraph: a.png: cannot write: it is a folder\n"), std::string::npos)
        << result.messages;
    EXPECT_EQ(result.output.find("a.exr\nb.png\na.json\n1 sample a pixel"), 0u) << result.output;
    for (const char* name : {"a.exr", "b.png", "a.json"})
        EXPECT_TRUE(std::filesystem::is_regular_file(folder / name)) << name;
}

TEST(ProgramOutputs, ASequenceGoesOnWithItsNextFrame) {
    const TemporaryFolder folder;
    const ProgramResult result =
        RunBlocked(folder, std::string(kTiny) + "--frames 0:0.08:0.04 -o f.#.png", "f.1.png");
    EXPECT_EQ(result.exitCode, 1);
    for (const char* name : {"f.0.png", "f.2.png"})
        EXPECT_TRUE(std::filesystem::is_regular_file(folder / name)) << name;
    EXPECT_NE(result.messages.find("raygraph: f.1.png: cannot write"), std::string::npos) << result.messages;
}

size_t CountOf(const std::string& text, const std::string& part) {
    size_t count = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
}

// SIGXCPU means that the processor time is up. It comes after a few checkpoints.
TEST(ProgramOutputs, CheckpointsAndTheStatusOfASignalAreThoseOfTheRender) {
    const TemporaryFolder folder;
    bool isTold = false;
    std::set<std::filesystem::file_time_type> saves;
    const ProgramResult result =
        RunBlocked(folder, std::string(kEndless) + "--checkpoint 0.001 -o a.exr -o a.png", "a.png",
                   [&](pid_t process, const std::string&) {
                       std::error_code none;
                       const auto saved = std::filesystem::last_write_time(folder / "a.exr", none);
                       if (!none) saves.insert(saved);
                       if (!isTold && saves.size() == 3) isTold = kill(process, SIGXCPU) == 0;
                   });
    EXPECT_TRUE(isTold);
    EXPECT_EQ(result.exitCode, 75) << result.messages;
    EXPECT_EQ(CountOf(result.messages, "not saved, rendering goes on: a.png: cannot write: it is a folder"),
              1u)
        << "for one reason once: " << result.messages;
    EXPECT_EQ(CountOf(result.messages, "raygraph: a.png: cannot write: it is a folder\n"), 1u)
        << result.messages;
    EXPECT_EQ(CountOf(result.messages, "; resumable .exr saved: a.exr\n"), 1u) << result.messages;
    EXPECT_GE(session::SampleCount(session::ReadRenderFile(folder / "a.exr").samples), 1u);
}

TEST(ProgramOutputs, ARenderThatCannotBeSavedIsNotTriedAgain) {
    const TemporaryFolder folder;
    bool isTold = false;
    const ProgramResult result = RunBlocked(folder, std::string(kEndless) + "-o a.exr -o a.png", "a.exr",
                                            [&](pid_t process, const std::string& messages) {
                                                if (!isTold && messages.find(" sample") != std::string::npos)
                                                    isTold = kill(process, SIGTERM) == 0;
                                            });
    EXPECT_EQ(result.exitCode, 1) << result.messages;
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "a.png"));
    EXPECT_EQ(result.messages.find("resumable"), std::string::npos) << result.messages;
}

TEST(ProgramOutputs, ARenderThatIsSavedToAnyFileIsTriedAgain) {
    const TemporaryFolder folder;
    bool isTold = false;
    const ProgramResult result = RunBlocked(folder, std::string(kEndless) + "-o a.exr -o b.exr -o a.png",
                                            "a.exr", [&](pid_t process, const std::string& messages) {
                                                if (!isTold && messages.find(" sample") != std::string::npos)
                                                    isTold = kill(process, SIGTERM) == 0;
                                            });
    EXPECT_EQ(result.exitCode, 75) << result.messages;
    EXPECT_EQ(CountOf(result.messages, "raygraph: a.exr: cannot write: it is a folder\n"), 1u)
        << result.messages;
    EXPECT_EQ(CountOf(result.messages, "; resumable .exr saved: b.exr\n"), 1u) << result.messages;
    EXPECT_GE(session::SampleCount(session::ReadRenderFile(folder / "b.exr").samples), 1u);
}

// A file of half floats lacks the sums with which a render is resumed; it is the only picture.
TEST(ProgramOutputs, AFileThatCannotBeResumedIsNotCalledResumable) {
    const TemporaryFolder folder;
    bool isTold = false;
    const ProgramResult result =
        RunProgramBeside(folder, std::string(kEndless) + "-o a.exr --exr-type half --progress plain",
                         [&](pid_t process, const std::string& messages) {
                             if (!isTold && messages.find(" sample") != std::string::npos)
                                 isTold = kill(process, SIGTERM) == 0;
                         });
    EXPECT_EQ(result.exitCode, 75) << result.messages;
    EXPECT_EQ(result.messages.find("resumable"), std::string::npos) << result.messages;
    EXPECT_NE(result.messages.find("; what there is was written\n"), std::string::npos) << result.messages;
}

// The reader of a pipe would take a checkpoint for the end, and stop.
TEST(ProgramOutputs, APipeGetsOnePictureAtTheEnd) {
    const TemporaryFolder folder;
    const std::filesystem::path pipe = folder / "p.png";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    bool isTold = false;
    int reader = -1;
    const ProgramResult result = RunProgramBeside(
        folder, std::string(kEndless) + "--checkpoint 0.001 -o p.png -o a.exr --progress json",
        [&](pid_t process, const std::string& messages) {
            if (isTold || CountOf(messages, R"("event":"written")") < 2) return;
            reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
            isTold = kill(process, SIGTERM) == 0;
        });
    EXPECT_EQ(result.exitCode, 75) << result.messages;
    EXPECT_EQ(result.messages.find("p.png: "), std::string::npos) << result.messages;
    std::string picture(1 << 16, '\0');
    picture.resize(static_cast<size_t>(std::max<ssize_t>(read(reader, picture.data(), picture.size()), 0)));
    close(reader);
    EXPECT_EQ(CountOf(picture, "IHDR"), 1u);
    EXPECT_EQ(CountOf(picture, "IEND"), 1u);
    EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

// The reader never comes, and a scheduler that has asked the program to end kills it while it waits.
TEST(ProgramOutputs, TheReportIsWrittenBeforeAPipe) {
    const TemporaryFolder folder;
    ASSERT_EQ(mkfifo((folder / "p.png").c_str(), 0600), 0);
    const ProgramResult result = RunProgramBeside(folder, std::string(kTiny) + "-o p.png --report r.json",
                                                  [&](pid_t process, const std::string&) {
                                                      if (std::filesystem::exists(folder / "r.json"))
                                                          kill(process, SIGKILL);
                                                  });
    EXPECT_EQ(result.exitCode, -1) << "it was not killed while it waited: " << result.messages;
    EXPECT_EQ(result.messages.find("nobody reads the pipe"), std::string::npos) << result.messages;
    EXPECT_TRUE(TextOf(folder / "r.json").ends_with("}\n"));
}

// A pipe does not store what an earlier run has written to it, and an empty file has no picture.
TEST(ProgramOutputs, ACompleteRenderIsWrittenToPipesAndEmptyFiles) {
    const TemporaryFolder folder;
    const std::string line =
        "render @cornell.gltf --brdf lambert --nee off --size 8x8 --spp 1 --checkpoint 10 --resume x.exr -o "
        "x.exr ";
    ASSERT_EQ(RunProgram(folder, line).exitCode, 0);
    const std::filesystem::path pipe = folder / "p.json";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
    const ProgramResult piped = RunProgram(folder, line + "--report p.json");
    EXPECT_EQ(piped.exitCode, 0) << piped.messages;
    std::string report(1 << 16, '\0');
    report.resize(static_cast<size_t>(std::max<ssize_t>(read(reader, report.data(), report.size()), 0)));
    close(reader);
    EXPECT_NE(report.find(R"("schema")"), std::string::npos);
    test::Put(folder / "empty.png", "");
    EXPECT_EQ(RunProgram(folder, line + "-o empty.png").exitCode, 0);
    EXPECT_GT(std::filesystem::file_size(folder / "empty.png"), 0u);
    const ProgramResult again = RunProgram(folder, line + "-o empty.png");
    EXPECT_NE(again.output.find("x.exr is complete: 1 sample a pixel"), std::string::npos) << again.output;
}

// The file is mounted by itself, as into a container, and its disk fills up: what is saved stays, and the
// status says so.
TEST(ProgramOutputs, AFileInPlaceOnAFullDiskKeepsItsCheckpoint) {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "disk");
    test::Put(folder / "a.exr", "");
    const std::string disk = folder / "disk", onDisk = disk + "/a.exr", mounted = folder / "a.exr";
    constexpr int kCannotMount = 99;
    bool isTold = false;
    int saved = -1;
    const ProgramResult result = RunProgramBeside(
        folder,
        "render @cornell.gltf --brdf lambert --nee off --size 32x32 --time 200 --checkpoint 0.001 -o a.exr "
        "-v",
        [&](pid_t process, const std::string& messages) {
            const std::string inside = "/proc/" + std::to_string(process) + "/root" + disk;
            if (saved < 0 && messages.find("resumable .exr saved") == std::string::npos) return;
            if (saved < 0) {
                saved = open((inside + "/a.exr").c_str(), O_RDONLY);
                std::ofstream filler(inside + "/filler", std::ios::binary);
                while (filler.write(std::string(4096, 'x').data(), 4096).flush()) {
                }
            }
            if (!isTold && messages.find("not saved, rendering goes on") != std::string::npos)
                isTold = kill(process, SIGTERM) == 0;
        },
        [&] {
            const bool isMounted = unshare(CLONE_NEWNS) == 0 &&
                                   mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
                                   mount("disk", disk.c_str(), "tmpfs", 0, "size=1m") == 0 &&
                                   close(open(onDisk.c_str(), O_WRONLY | O_CREAT, 0600)) == 0 &&
                                   mount(onDisk.c_str(), mounted.c_str(), nullptr, MS_BIND, nullptr) == 0;
            if (!isMounted) _exit(kCannotMount);
        });
    if (result.exitCode == kCannotMount) GTEST_SKIP() << "mounting is not allowed here";
    ASSERT_TRUE(isTold) << result.messages;
    EXPECT_EQ(result.exitCode, 75) << result.messages;
    EXPECT_NE(result.messages.find("a.exr: cannot write: No space left on device\n"), std::string::npos);
    std::filesystem::copy_file("/proc/self/fd/" + std::to_string(saved), folder / "kept.exr");
    close(saved);
    EXPECT_GE(session::SampleCount(session::ReadRenderFile(folder / "kept.exr").samples), 1u);
}

// A script starts background commands in this way, and so does `trap '' TERM`.
TEST(ProgramOutputs, ASignalThatIsIgnoredDoesNotEndIt) {
    const TemporaryFolder folder;
    bool isTold = false;
    const ProgramResult result = RunProgramBeside(
        folder, "render @cornell.gltf --view albedo --size 16x16 --spp 40 -o a.exr --progress json",
        [&](pid_t process, const std::string& messages) {
            if (isTold || messages.find(R"("progress")") == std::string::npos) return;
            isTold = true;
            for (const int signal : {SIGINT, SIGTERM, SIGHUP}) kill(process, signal);
        },
        [] {
            for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_IGN);
        });
    EXPECT_TRUE(isTold);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_EQ(session::SampleCount(session::ReadRenderFile(folder / "a.exr").samples), 40u);
}

TEST(ProgramOutputs, AReaderOfItsProgressThatLeavesDoesNotEndIt) {
    const TemporaryFolder folder;
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    close(ends[0]);
    const ProgramResult result = RunPrepared(folder, std::string(kTiny) + "-o a.png --progress json",
                                             [&] { dup2(ends[1], STDERR_FILENO); });
    close(ends[1]);
    EXPECT_EQ(result.exitCode, 0);
    EXPECT_TRUE(std::filesystem::exists(folder / "a.png"));
}

// The report is the smaller of the two files. The command uses no device, since the limit would apply to
// files of a CPU driver, too.
TEST(ProgramOutputs, AFileBeyondTheLimitIsOneThatCannotBeWritten) {
    const TemporaryFolder folder;
    ASSERT_EQ(
        RunProgram(folder, "render @cornell.gltf --view albedo --size 64x64 --spp 1 -o part.exr").exitCode,
        0);
    ASSERT_GT(std::filesystem::file_size(folder / "part.exr"), 3000u);
    const ProgramResult result = RunPrepared(folder, "merge part.exr -o whole.exr --report m.json", [] {
        const rlimit bytes{3000, 3000};
        setrlimit(RLIMIT_FSIZE, &bytes);
    });
    EXPECT_EQ(result.exitCode, 1);
    EXPECT_EQ(result.messages, "raygraph: whole.exr: cannot write: File too large\n");
    EXPECT_FALSE(std::filesystem::exists(folder / "whole.exr"));
    EXPECT_TRUE(std::filesystem::exists(folder / "m.json"));
}

TEST(ProgramOutputs, StdoutThatCannotBeWrittenIsAFailure) {
    const TemporaryFolder folder;
    const auto full = [] {
        const int descriptor = open("/dev/full", O_WRONLY);
        dup2(descriptor, STDOUT_FILENO);
    };
    for (const std::string line : {"--help", "info @cornell.gltf", "info --json --extensions",
                                   "graph @cornell.gltf --size 8x8 --json"}) {
        const ProgramResult result = RunPrepared(folder, line, full);
        EXPECT_EQ(result.exitCode, 1) << line;
        EXPECT_TRUE(result.messages.starts_with("raygraph: stdout cannot be written")) << result.messages;
        EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
    }
    const ProgramResult quiet = RunPrepared(folder, std::string(kTiny) + "-o a.png --quiet", full);
    EXPECT_EQ(quiet.exitCode, 0) << "which has nothing to say: " << quiet.messages;
}

// Otherwise the picture would be opened as file descriptor 1, and get the text.
TEST(ProgramOutputs, StdoutThatIsClosedIsAFailureAndNoOtherFile) {
    const TemporaryFolder folder;
    ASSERT_EQ(RunProgram(folder, std::string(kTiny) + "-o good.png").exitCode, 0);
    const ProgramResult result =
        RunPrepared(folder, std::string(kTiny) + "-o a.png", [] { close(STDOUT_FILENO); });
    EXPECT_EQ(result.exitCode, 1);
    // Which write fails first, and so whether there is a reason, is the C library's choice.
    EXPECT_EQ(result.messages.find("raygraph: stdout cannot be written"), 0u) << result.messages;
    EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
    EXPECT_EQ(TextOf(folder / "a.png"), TextOf(folder / "good.png"));
}

}  // namespace
}  // namespace raygraph::program_outputs_test

// Tests renders that are saved while they run, ended by signals, and resumed. It needs a device.
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

// Settings that compile quickly.
constexpr const char* kSmall = "render @cornell.gltf --brdf lambert --nee off --size 16x16 ";
// This render would take hours.
constexpr const char* kEndless =
    "render @cornell.gltf --brdf lambert --nee off --size 16x16 --spp 100000000 --progress plain ";

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
        const std::string options = Text("{}--spp {} --aov depth ", kSmall, samples);
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
    }
}

// Ctrl-C ends a render with checkpoints as it ends any other.
TEST(ProgramCheckpoint, ASaveOnDemandDoesNotEndTheRender) {
    const TemporaryFolder folder;
    bool isAsked = false, isCopied = false;
    const ProgramResult result =
        RunProgramBeside(folder, std::string(kEndless) + "--checkpoint 60 -o a.exr",
                         [&](pid_t process, const std::string& messages) {
                             if (!isAsked && messages.find(" sample") != std::string::npos) {
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
    RunWell(folder, Text("{}--spp {} -o whole.exr", kSmall, saved));
    EXPECT_EQ(TextOf(folder / "saved.exr"), TextOf(folder / "whole.exr"));
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
    const ProgramResult result =
        RunProgram(folder, std::string(kSmall) + "--time 0.5 --checkpoint 0.25 -o a.exr --progress json");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_EQ(TimesWritten(result.messages), 1u) << result.messages;
}

TEST(ProgramCheckpoint, ATimeLimitIsOfAllThatIsRenderedBetweenCheckpoints) {
    const TemporaryFolder folder;
    // Compile first: that would exceed the time
    RunWell(folder, std::string(kSmall) + "--spp 1 -o a.exr");
    const ProgramResult result = RunProgram(folder, std::string(kSmall) +
                                                        "--time 1.5 --checkpoint 0.001 -o a.exr "
                                                        "--report a.json --progress json");
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
    RunWell(folder, "render @cornell.gltf --brdf lambert --nee off --size 400x400 --spp 1 -o a.png -o a.exr");
    const auto written = [&](const char* name) { return std::filesystem::last_write_time(folder / name); };
    EXPECT_LE(written("a.exr"), written("a.png"));
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

TEST(ProgramCheckpoint, UntilThereIsASampleASignalEndsARenderAtOnce) {
    struct Row {
        const char* stage;
        int signal, exitCode;
    };
    const test::EnvironmentVariable cache("MESA_SHADER_CACHE_DISABLE", "true");
    for (const Row& row : {Row{"loading", SIGTERM, 75}, Row{"compiling shaders", SIGTERM, 75},
                           Row{"compiling shaders", SIGINT, -1}}) {
        SCOPED_TRACE(row.stage);
        const TemporaryFolder folder;
        std::ofstream(folder / "a.exr") << "old";
        bool isSent = false;
        const ProgramResult result = RunProgramBeside(
            folder, "render @cornell.gltf --size 16x16 --spp 100000000 --progress plain -o a.exr",
            [&](pid_t process, const std::string& messages) {
                if (isSent || messages.find(row.stage) == std::string::npos) return;
                isSent = true;
                kill(process, row.signal);
            });
        EXPECT_EQ(result.exitCode, row.exitCode);
        EXPECT_EQ(TextOf(folder / "a.exr"), "old");
        EXPECT_EQ(result.messages.find("stopped after"), std::string::npos) << result.messages;
        EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.Path()), {}), 1);
    }
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
    const std::string frames =
        "--brdf lambert --nee off --size 8x6 --frames 0:0.04:0.04 --checkpoint 60 --resume f.#.exr -o "
        "f.#.exr ";
    RunWell(folder, "render @cornell.gltf --spp 1 " + frames);
    const auto refuse = [&](const std::string& options, const std::string& difference) {
        ExpectRefused(
            folder, options, 4,
            "f.0.exr is complete, but another picture than the one that is asked for: " + difference);
    };
    refuse(frames + "--spp 1 --seed 5", "seed: 0 against 5");
    refuse(frames + "--spp 1 --aov depth", "its channels");
    refuse(frames + "--spp 1 --sample-offset 7", "first sample: 0 against 7");
    const ProgramResult other = RunProgram(folder,
                                           "render @terrace.gltf --brdf lambert --nee off --size 8x6 --at 0 "
                                           "--spp 1 --checkpoint 60 --resume f.0.exr "
                                           "-o f.0.exr");
    EXPECT_EQ(other.exitCode, 4);
    EXPECT_NE(other.messages.find("scene: cornell.gltf against terrace.gltf"), std::string::npos)
        << other.messages;
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
    const int code = RunUntil(folder, line, SIGUSR2).exitCode;
    EXPECT_TRUE(code == 75 || code == 0) << code;
    RunWell(folder, line);
    EXPECT_EQ(SamplesIn(folder / "a.exr"), wanted);
    EXPECT_EQ(TextOf(folder / "a.exr"), TextOf(folder / "whole.exr"));
    EXPECT_EQ(RunWell(folder, line), Text("a.exr is complete: {} samples a pixel\n", wanted));
}

TEST(ProgramCheckpoint, WhatCannotBeSavedOrGoneOnWithIsRefused) {
    const TemporaryFolder folder;
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

// Tests --progress as a script or a log file gets it. It needs a device.
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
    for (const char* silent : {"", " --progress none"})
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

}  // namespace
}  // namespace raygraph::program_progress_test
