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
#include <set>

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
constexpr const char* kEndless = "render @cornell.gltf --size 16x16 --time 200 ";

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
                                                if (!isTold && messages.find(" samples") != std::string::npos)
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
                                                if (!isTold && messages.find(" samples") != std::string::npos)
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
                             if (!isTold && messages.find(" samples") != std::string::npos)
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
        "render @cornell.gltf --size 8x8 --spp 1 --checkpoint 10 --resume x.exr -o x.exr ";
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
        folder, "render @cornell.gltf --size 32x32 --time 200 --checkpoint 0.001 -o a.exr -v",
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
        folder, "render @cornell.gltf --size 16x16 --spp 40 -o a.exr --progress json",
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
