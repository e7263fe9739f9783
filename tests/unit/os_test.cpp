// The operating system, and the log.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <poll.h>
#include <pty.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "base/large_pages.h"
#include "base/log.h"
#include "base/os.h"
#include "base/text.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

// Tests base/os, the interface to the operating system.
namespace raygraph::os::os_test {
namespace {

using Path = std::filesystem::path;
using test::FileCount;
using test::TextOf;

class OsFile : public ::testing::Test {
  protected:
    Path Write(const char* name, const std::string& text) const {
        std::ofstream(folder.Path() / name, std::ios::binary) << text;
        return folder.Path() / name;
    }
    std::error_code error;
    test::TemporaryFolder folder;
};

TEST_F(OsFile, IsReadFromWhereTheLastReadEnded) {
    InputFile file(Write("a", "0123456789"), Links::Follow, error);
    ASSERT_FALSE(error);
    EXPECT_EQ(file.RegularSize(error), 10u);
    std::array<char, 6> part{};
    EXPECT_EQ(file.Read(std::as_writable_bytes(std::span(part)), error), 6u);
    EXPECT_EQ(std::string(part.data(), 6), "012345");
    EXPECT_EQ(file.Read(std::as_writable_bytes(std::span(part)), error), 4u) << "there it ends";
    EXPECT_EQ(std::string(part.data(), 4), "6789");
    EXPECT_EQ(file.Read(std::as_writable_bytes(std::span(part)), error), 0u);
    EXPECT_FALSE(error);
}

TEST_F(OsFile, ThatIsNotThereIsAnErrorCode) {
    const InputFile file(folder.Path() / "none", Links::Follow, error);
    EXPECT_EQ(error, std::errc::no_such_file_or_directory);
}

TEST_F(OsFile, LinkAtTheEndOfThePathIsFollowedOrRefused) {
    const Path target = Write("a", "text"), link = folder.Path() / "link";
    std::filesystem::create_symlink(target, link);
    InputFile followed(link, Links::Follow, error);
    EXPECT_FALSE(error);
    EXPECT_EQ(followed.RegularSize(error), 4u);
    const InputFile refused(link, Links::Refuse, error);
    EXPECT_TRUE(error);
    const InputFile itself(target, Links::Refuse, error);
    EXPECT_FALSE(error) << error.message();
}

TEST_F(OsFile, WhatIsNoRegularFileHasNoSizeAndDoesNotBlock) {
    const Path pipe = folder.Path() / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    for (const Path& path : {pipe, folder.Path(), Path("/dev/null")}) {
        const InputFile file(path, Links::Follow, error);  // a pipe without a writer would block
        ASSERT_FALSE(error) << path << ": " << error.message();
        EXPECT_EQ(file.RegularSize(error), std::nullopt) << path;
        EXPECT_FALSE(error);
    }
    InputFile isFolder(folder.Path(), Links::Follow, error);
    std::array<std::byte, 4> bytes{};
    EXPECT_EQ(isFolder.Read(bytes, error), 0u);
    EXPECT_TRUE(error) << "a folder cannot be read";
}

TEST_F(OsFile, NewOneIsSeenOnceItIsPublishedAndGoneIfItIsNot) {
    {
        NewFile file(folder.Path(), std::nullopt, error);
        ASSERT_FALSE(error) << error.message();
        std::fputs("0123456789", file.Stream());
        EXPECT_EQ(Position(file.Stream(), error), 10u);
        Seek(file.Stream(), 4, error);
        EXPECT_FALSE(error);
        EXPECT_EQ(std::fgetc(file.Stream()), '4');
        Seek(file.Stream(), 2, error);
        std::fputc('x', file.Stream());
        file.Close(error);
        EXPECT_FALSE(error) << error.message();
        EXPECT_FALSE(std::filesystem::exists(folder / "new"));
        file.Publish("new", error);
        EXPECT_FALSE(error) << error.message();
    }
    EXPECT_EQ(TextOf(folder / "new"), "01x3456789");
    const NewFile dropped(folder.Path(), std::nullopt, error);
    EXPECT_FALSE(error);
    EXPECT_EQ(FileCount(folder.Path()), 1u);
}

TEST_F(OsFile, NewOneTakesThePermissionsThatAreGiven) {
    constexpr auto kOwn = std::filesystem::perms::owner_read | std::filesystem::perms::owner_write;
    NewFile file(folder.Path(), kOwn, error);
    ASSERT_FALSE(error);
    file.Close(error);
    file.Publish("own", error);
    EXPECT_EQ(std::filesystem::status(folder / "own").permissions(), kOwn);
}

TEST_F(OsFile, NewOneReplacesALinkAndNotWhatItLeadsTo) {
    const Path path = Write("a", "old");
    std::filesystem::create_symlink(path, folder / "link");
    NewFile file(folder.Path(), std::nullopt, error);
    file.Close(error);
    file.Publish("link", error);
    EXPECT_FALSE(error) << error.message();
    EXPECT_EQ(TextOf(path), "old");
    EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(folder / "link")));
}

TEST_F(OsFile, NewOneNeedsAFolder) {
    for (const Path& none : {folder / "none", Write("a", "text")}) {
        error.clear();
        const NewFile file(none, std::nullopt, error);
        EXPECT_TRUE(error) << none;
        EXPECT_EQ(file.Stream(), nullptr);
    }
}

TEST_F(OsFile, AskingWhetherItCanBeReplacedLeavesIt) {
    const Path path = Write("a", "text");
    EXPECT_FALSE(CheckReplaceable(path));
    EXPECT_FALSE(CheckOverwritable(path));
    EXPECT_EQ(TextOf(path), "text");
    EXPECT_FALSE(CheckOverwritable("/dev/null"));
    EXPECT_EQ(CheckOverwritable(folder / "none"), std::errc::no_such_file_or_directory);
    // The folder is empty, and may have replaced a file after that was checked
    std::filesystem::create_directory(folder / "b");
    EXPECT_EQ(CheckReplaceable(folder / "b"), std::errc::is_a_directory);
    EXPECT_TRUE(std::filesystem::is_directory(folder / "b"));
    EXPECT_FALSE(CheckReplaceable(folder / "none"));
}

TEST_F(OsFile, StreamsWithoutPositionsReportThat) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    std::FILE* stream = fdopen(ends[1], "w");
    Position(stream, error);
    EXPECT_TRUE(error);
    error.clear();
    Seek(stream, 1, error);
    EXPECT_TRUE(error);
    std::fclose(stream);
    close(ends[0]);
}

TEST(OsLibrary, FunctionsAreFoundByName) {
    std::string why;
    void* const library = OpenLibrary("libm.so.6", why);
    ASSERT_NE(library, nullptr) << why;
    const auto root = reinterpret_cast<double (*)(double)>(FunctionOf(library, "sqrt"));
    ASSERT_NE(root, nullptr);
    EXPECT_EQ(root(9.0), 3.0);
    EXPECT_EQ(FunctionOf(library, "no_such_function"), nullptr);
}

TEST(OsLibrary, ThatIsNotThereSaysWhy) {
    std::string why;
    EXPECT_EQ(OpenLibrary("libno_such_library.so.1", why), nullptr);
    EXPECT_NE(why.find("libno_such_library.so.1"), std::string::npos) << why;
}

TEST(OsProcess, TimeOfTheProcessorCountsWorkAndNotRest) {
    const double before = ProcessCpuSeconds();
    volatile double sum = 0.0;
    while (ProcessCpuSeconds() - before < 0.02) sum = sum + 1.0;
    const double worked = ProcessCpuSeconds();
    EXPECT_GE(worked - before, 0.02);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    EXPECT_LT(ProcessCpuSeconds() - worked, 0.15);
}

TEST(OsProcess, PeakMemoryCountsWhatIsTouchedAndDoesNotFall) {
    constexpr size_t kBytes = size_t{64} << 20;
    const uint64_t before = PeakResidentBytes();
    uint64_t during = 0;
    {
        const std::vector<char> memory(kBytes, 1);
        during = PeakResidentBytes();
        EXPECT_EQ(memory[kBytes / 2], 1);
    }
    EXPECT_GE(during, kBytes);
    EXPECT_GE(during, before);
    EXPECT_GE(PeakResidentBytes(), during);
}

TEST(OsProcess, TimeOfDayIsThatOfTheTimeZone) {
    const auto expected = [] {
        const time_t now = std::time(nullptr);
        char text[16];
        std::strftime(text, sizeof text, "%H:%M:%S", std::localtime(&now));
        return std::string(text);
    };
    const std::string before = expected(), told = LocalTimeOfDay(), after = expected();
    EXPECT_TRUE(told == before || told == after) << before << ' ' << told << ' ' << after;
}

TEST(OsProcess, TerminalIsKnownWithItsWidth) {
    const winsize size{.ws_row = 10, .ws_col = 37, .ws_xpixel = 0, .ws_ypixel = 0};
    int outside = -1, inside = -1;
    ASSERT_EQ(openpty(&outside, &inside, nullptr, nullptr, &size), 0);
    std::FILE* terminal = fdopen(inside, "w");
    EXPECT_TRUE(IsTerminal(terminal));
    EXPECT_EQ(TerminalWidth(terminal), 37u);
    std::fclose(terminal);
    close(outside);
    std::FILE* file = std::tmpfile();
    EXPECT_FALSE(IsTerminal(file));
    EXPECT_EQ(TerminalWidth(file), 80u);
    std::fclose(file);
}

TEST(OsProcess, PatternsAreTheShells) {
    EXPECT_TRUE(MatchesPattern("lamp", "lamp"));
    EXPECT_TRUE(MatchesPattern("lamp 3", "lamp*"));
    EXPECT_TRUE(MatchesPattern("lamp", "l?m[a-p]"));
    EXPECT_FALSE(MatchesPattern("lamp 3", "lamp"));
    EXPECT_FALSE(MatchesPattern("Lamp", "lamp"));
    EXPECT_FALSE(MatchesPattern("", "?"));
    EXPECT_TRUE(MatchesPattern("", "*"));
}

volatile std::sig_atomic_t othersCalls = 0;

void EndAtOnce() {
    std::_Exit(75);
}

TEST(OsSignals, AreNotedAndLeftToOthersAfterwards) {
    const auto before = std::signal(SIGTERM, [](int) { othersCalls = othersCalls + 1; });
    {
        SignalWatch watch(EndAtOnce);
        watch.StartDeferring();
        EXPECT_FALSE(watch.IsTerminated());
        std::raise(SIGTERM);
        EXPECT_TRUE(watch.IsTerminated());
        EXPECT_FALSE(watch.IsInterrupted());
        std::raise(SIGTERM);
        EXPECT_EQ(othersCalls, 0) << "nor by a second one, which clusters send";
    }
    std::raise(SIGTERM);
    EXPECT_EQ(othersCalls, 1);
    {
        SignalWatch watch(EndAtOnce);
        watch.StartDeferring();
        EXPECT_FALSE(watch.IsTerminated()) << "what an earlier one noted is past";
        std::raise(SIGUSR2);
        EXPECT_TRUE(watch.IsTerminated());
        EXPECT_FALSE(watch.IsInterrupted());
        std::raise(SIGINT);
        EXPECT_TRUE(watch.IsInterrupted());
    }
    std::signal(SIGTERM, before);
}

volatile std::sig_atomic_t othersSignal = 0;

TEST(OsSignals, EachGoesToWhoHadItBefore) {
    constexpr std::array kSignals{SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGHUP, SIGXCPU};
    std::array<void (*)(int), kSignals.size()> before{};
    for (size_t i = 0; i < kSignals.size(); ++i)
        before[i] = std::signal(kSignals[i], [](int signal) { othersSignal = signal; });
    {
        SignalWatch watch(EndAtOnce);
        watch.StartDeferring();
    }
    for (const int signal : kSignals) {
        othersSignal = 0;
        std::raise(signal);
        EXPECT_EQ(othersSignal, signal);
    }
    for (size_t i = 0; i < kSignals.size(); ++i) std::signal(kSignals[i], before[i]);
}

TEST(OsSignals, SaveIsNotedFromTheStartAndForgottenOnceItIsDone) {
    SignalWatch watch(EndAtOnce);
    EXPECT_FALSE(watch.IsSaveRequested());
    std::raise(SIGUSR1);
    EXPECT_TRUE(watch.IsSaveRequested());
    watch.ClearSaveRequest();
    EXPECT_FALSE(watch.IsSaveRequested());
    std::raise(SIGUSR1);
    EXPECT_TRUE(watch.IsSaveRequested());
    EXPECT_FALSE(watch.IsTerminated());
}

TEST(OsSignals, EachThatAsksToEndIsNoted) {
    for (const int signal : {SIGTERM, SIGUSR2, SIGHUP, SIGXCPU}) {
        SignalWatch watch(EndAtOnce);
        watch.StartDeferring();
        std::raise(signal);
        EXPECT_TRUE(watch.IsTerminated()) << signal;
        EXPECT_FALSE(watch.IsInterrupted()) << signal;
    }
}

// nohup, `trap '' TERM` and the background of a script start a process in this way.
TEST(OsSignals, OneThatWasIgnoredBeforeStaysIgnored) {
    constexpr std::array kSignals{SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGHUP, SIGXCPU};
    for (const int signal : kSignals) {
        const auto before = std::signal(signal, SIG_IGN);
        {
            SignalWatch watch(EndAtOnce);
            watch.StartDeferring();
            std::raise(signal);
            EXPECT_FALSE(watch.IsInterrupted() || watch.IsTerminated() || watch.IsSaveRequested()) << signal;
        }
        EXPECT_EQ(std::signal(signal, before), SIG_IGN) << signal;
    }
}

// Returns the flags of the mapping that contains an address, as Linux names them; empty if it does not say.
std::string MappingFlags(const void* address) {
    std::ifstream maps("/proc/self/smaps");
    bool isInside = false;
    for (std::string line; std::getline(maps, line);) {
        unsigned long first = 0, end = 0;
        if (std::sscanf(line.c_str(), "%lx-%lx ", &first, &end) == 2)
            isInside = reinterpret_cast<uintptr_t>(address) - first < end - first;
        else if (isInside && line.starts_with("VmFlags:"))
            return line;
    }
    return {};
}

TEST(LargeArray, IsInLargePagesIfItIsLarge) {
    const LargeArray<uint64_t> small(1000, 3), large(3'000'000, 7);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(large.data()) % (2u << 20), 0u);
    EXPECT_EQ(small.back() + large.front() + large.back(), 17u);
    const std::string flags = MappingFlags(large.data());
    if (flags.empty() || !std::filesystem::exists("/sys/kernel/mm/transparent_hugepage"))
        GTEST_SKIP() << "this kernel has no large pages";
    EXPECT_NE((flags + " ").find(" hg "), std::string::npos) << flags;
}

// These tests run in a child, since they change its streams and signals.
TEST(OsProcessDeathTest, WritesFailInsteadOfEndingTheProcess) {
    const auto writeInVain = [] {
        IgnoreWriteSignals();
        int ends[2];
        if (pipe(ends) != 0) std::_Exit(1);
        close(ends[0]);
        if (write(ends[1], "x", 1) != -1 || errno != EPIPE) std::_Exit(2);
        const rlimit limit{1, 1};
        std::FILE* file = std::tmpfile();
        if (file == nullptr || setrlimit(RLIMIT_FSIZE, &limit) != 0) std::_Exit(3);
        if (write(fileno(file), "xy", 2) != 1 || write(fileno(file), "y", 1) != -1 || errno != EFBIG)
            std::_Exit(4);
        std::_Exit(0);
    };
    EXPECT_EXIT(writeInVain(), ::testing::ExitedWithCode(0), "");
}

TEST(OsProcessDeathTest, NoFileTakesThePlaceOfAClosedStream) {
    const auto open = [] {
        for (const int stream : {0, 1, 2}) close(stream);
        IgnoreWriteSignals();
        std::FILE* file = std::tmpfile();
        if (file == nullptr || fileno(file) <= 2) std::_Exit(1);
        char byte = 0;
        std::_Exit(write(1, "x", 1) == -1 && write(2, "x", 1) == -1 && read(0, &byte, 1) == -1 ? 0 : 2);
    };
    EXPECT_EXIT(open(), ::testing::ExitedWithCode(0), "");
}

TEST(OsSignalsDeathTest, SecondInterruptEndsTheProcess) {
    const auto interruptTwice = [] {
        SignalWatch watch(EndAtOnce);
        watch.StartDeferring();
        std::raise(SIGINT);
        std::raise(SIGINT);
        std::_Exit(0);
    };
    EXPECT_EXIT(interruptTwice(), ::testing::KilledBySignal(SIGINT), "");
}

TEST(OsSignalsDeathTest, TerminationEndsTheProcessWhileThereIsNothingToSave) {
    for (const int signal : {SIGTERM, SIGUSR2, SIGHUP, SIGXCPU}) {
        const auto terminate = [signal] {
            const SignalWatch watch(EndAtOnce);
            std::raise(signal);
            std::_Exit(0);
        };
        EXPECT_EXIT(terminate(), ::testing::ExitedWithCode(75), "");
    }
}

TEST(OsChildProcess, IsAskedToEndWhenItsParentIsKilled) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t parent = fork();
    ASSERT_GE(parent, 0);
    if (parent == 0) {
        dup2(ends[1], STDERR_FILENO);
        const ChildProcess child(
            {"sh", "-c",
             "trap 'echo asked >&2; exit' TERM; echo ready >&2; for i in $(seq 1000); do "
             "sleep 0.01; done"});
        pause();
    }
    close(ends[1]);
    std::string text(16, '\0');
    const auto next = [&] {
        return text.substr(0, size_t(std::max<ssize_t>(read(ends[0], text.data(), 16), 0)));
    };
    EXPECT_EQ(next(), "ready\n");
    kill(parent, SIGKILL);
    waitpid(parent, nullptr, 0);
    pollfd waited{ends[0], POLLIN, 0};
    EXPECT_EQ(poll(&waited, 1, 10'000), 1);
    EXPECT_EQ(next(), "asked\n");
    close(ends[0]);
}

TEST(OsProcess, AWordForAShellIsQuotedWhereItHasTo) {
    EXPECT_EQ(ForShell("a/b-1.png"), "a/b-1.png");
    EXPECT_EQ(ForShell("two words"), "\"two words\"");
    EXPECT_EQ(ForShell("it's $1"), "'it'\\''s $1'");
    EXPECT_EQ(ForShell(""), "\"\"");
}

// A parent's handlers and ignored signals are not the child's, nor are signals blocked in it.
TEST(OsChildProcess, HasTheSignalsOfAProgramThatIsStarted) {
    const auto before = std::signal(SIGUSR1, [](int) {});
    ChildProcess child({"sed", "-n", "/SigBlk/p;/SigCgt/p", "/proc/self/status"});
    std::signal(SIGUSR1, before);
    while (child.IsRunning()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(child.Output(), "SigBlk:\t0000000000000000\nSigCgt:\t0000000000000000\n");
}

TEST(OsChildProcess, GivesItsOutputOrNoneOfAFailureAndEndsWithTheObject) {
    const auto outputOf = [](const std::vector<std::string>& command) {
        ChildProcess child(command);
        while (child.IsRunning()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return child.Output();
    };
    EXPECT_EQ(outputOf({"printf", "%s|", "a b", "$HOME"}), "a b|$HOME|");
    EXPECT_EQ(outputOf({"sh", "-c", "echo lost; exit 1"}), std::nullopt);
    EXPECT_EQ(outputOf({"raygraph-no-such-program"}), std::nullopt);
    ChildProcess failing({"sh", "-c", "echo out; echo why >&2; exit 3"}, ErrorStream::WithOutput);
    while (failing.IsRunning()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(failing.TakeWritten(), "out\nwhy\n");
    EXPECT_EQ(failing.TakeWritten(), "");
    EXPECT_TRUE(failing.IsStarted());
    EXPECT_FALSE(ChildProcess({"raygraph-no-such-program"}).IsStarted());
    EXPECT_EQ(failing.ExitStatus(), 3);
    EXPECT_TRUE(std::filesystem::exists(ProgramFile()));
    const auto start = std::chrono::steady_clock::now();
    {
        ChildProcess killed({"sh", "-c", "trap '' TERM; exec sleep 600"});
        killed.Kill();
        EXPECT_FALSE(killed.IsRunning());
        EXPECT_EQ(killed.ExitStatus(), std::nullopt);
        ChildProcess sleeping({"sleep", "600"});
        EXPECT_TRUE(sleeping.IsRunning());
    }
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
    EXPECT_TRUE(FindProgram("sh"));
    EXPECT_FALSE(FindProgram("raygraph-no-such-program"));
}

}  // namespace
}  // namespace raygraph::os::os_test

namespace raygraph::log_test {
namespace {

TEST(Log, MessagesBelowItsLevelAreNotMade) {
    for (const LogLevel least :
         {LogLevel::Debug, LogLevel::Info, LogLevel::Warning, LogLevel::Error, LogLevel::Off}) {
        std::vector<LogLevel> sent;
        const Log log([&](const LogMessage& message) { sent.push_back(message.level); }, least);
        for (const LogLevel level : {LogLevel::Debug, LogLevel::Info, LogLevel::Warning, LogLevel::Error}) {
            EXPECT_EQ(log.IsEnabled(level), level >= least);
            log.Send(level, log_category::kScene, "text");
        }
        EXPECT_FALSE(log.IsEnabled(LogLevel::Off)) << "it is a threshold, and no message's level";
        log.Send(LogLevel::Off, log_category::kScene, "text");
        EXPECT_EQ(sent.size(), size_t(LogLevel::Off) - size_t(least)) << Name(least);
        for (const LogLevel level : sent) EXPECT_GE(level, least);
    }
}

TEST(Log, WithoutACallbackNobodyListens) {
    for (const Log& log : {Log(), Log(Log::Callback(), LogLevel::Debug)}) {
        EXPECT_FALSE(log.IsEnabled(LogLevel::Error));
        log.Send(LogLevel::Error, log_category::kScene, "nobody hears it");
        EXPECT_FALSE(log.IsEnabled(LogLevel::Off));
        log.Send(LogLevel::Off, log_category::kScene, "nor this");
    }
}

TEST(Log, WhatTheCallbackThrowsIsDropped) {
    int calls = 0;
    const Log log(
        [&](const LogMessage&) {
            ++calls;
            throw 17;  // not even an exception
        },
        LogLevel::Info);
    EXPECT_NO_THROW(log.Send(LogLevel::Info, log_category::kScene, "text"));
    EXPECT_NO_THROW(WriteLog(log, LogLevel::Info, log_category::kScene, "number {}", 3));
    EXPECT_EQ(calls, 2);
}

struct Counted {
    int& formatted;
};

}  // namespace
}  // namespace raygraph::log_test

template <>
struct fmt::formatter<raygraph::log_test::Counted> : fmt::formatter<int> {
    auto format(const raygraph::log_test::Counted& value, fmt::format_context& context) const {
        return fmt::formatter<int>::format(++value.formatted, context);
    }
};

namespace raygraph::log_test {
namespace {

TEST(Log, TextsAreFormattedOnlyForWhoListens) {
    std::string heard;
    const Log log(
        [&](const LogMessage& message) {
            heard += std::string(message.category) + ": " + std::string(message.text);
        },
        LogLevel::Info);
    int formatted = 0;
    WriteLog(log, LogLevel::Debug, log_category::kCache, "{}", Counted{formatted});
    EXPECT_EQ(formatted, 0);
    WriteLog(log, LogLevel::Info, log_category::kCache, "number {}", Counted{formatted});
    EXPECT_EQ(heard, "cache: number 1");
}

TEST(Text, ErrorsHaveKindAndFormattedText) {
    const Error error = MakeError(ErrorKind::BadInput, "{}: {} of {}", "a.glb", 3, 2u);
    EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
    EXPECT_STREQ(error.what(), "a.glb: 3 of 2");
}

TEST(Text, BytesHaveUnits) {
    EXPECT_EQ(BytesText(0), "0 B");
    EXPECT_EQ(BytesText(512), "512 B");
    EXPECT_EQ(BytesText(1536), "1.5 KiB");
    EXPECT_EQ(BytesText(uint64_t{24} << 20), "24 MiB");
    EXPECT_EQ(BytesText(uint64_t{3} << 40), "3 TiB");
}

TEST(Text, DurationsHaveUnits) {
    EXPECT_EQ(DurationText(0.00042), "0.4 ms");
    EXPECT_EQ(DurationText(0.0123), "12 ms");
    EXPECT_EQ(DurationText(1.26), "1.3 s");
    EXPECT_EQ(DurationText(59.4), "59 s");
    EXPECT_EQ(DurationText(59.6), "1 min 0 s");
    EXPECT_EQ(DurationText(200.0), "3 min 20 s");
    EXPECT_EQ(DurationText(3723), "1 h 2 min");
}

}  // namespace
}  // namespace raygraph::log_test
