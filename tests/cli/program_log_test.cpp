// Tests levels, and the targets of messages: stderr, a file, a listener.
#include "editor/cli/program_log.h"

#include <algorithm>
#include <fstream>
#include <thread>

#include "tests/cli/cli_test.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::cli::program_log_test {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

TEST(LogLevels, OneForAllAndOthersByCategory) {
    EXPECT_EQ(ParseLogLevels("info").general, LogLevel::Info);
    const LogLevels levels = ParseLogLevels("warning,cache=off,shaders=debug");
    EXPECT_EQ(levels.Of("scene"), LogLevel::Warning);
    EXPECT_EQ(levels.Of("cache"), LogLevel::Off);
    EXPECT_EQ(levels.Of("shaders"), LogLevel::Debug);
    EXPECT_EQ(levels.Lowest(), LogLevel::Debug);
    EXPECT_EQ(ParseLogLevels("scene=info").Of("cache"), LogLevel::Warning) << "as without it";
    const LogLevels more = levels.AtLeast(LogLevel::Info);
    EXPECT_EQ(more.Of("scene"), LogLevel::Info);
    EXPECT_EQ(more.Of("cache"), LogLevel::Off) << "who names a category means it";
    EXPECT_EQ(ParseLogLevels("debug").AtLeast(LogLevel::Info).general, LogLevel::Debug);
}

TEST(LogLevels, WhatIsNoneIsRefusedWithWhatThereIs) {
    for (const char* text : {"", "loud", "info,", "Info", "scene=", "info;debug", "info,loud"})
        ExpectError(
            ErrorKind::BadInput, [&] { ParseLogLevels(text); }, "debug, info, warning, error, off");
    ExpectError(
        ErrorKind::BadInput, [] { ParseLogLevels("info,sound=debug"); }, "\"sound\"", "scene, device");
}

// Returns what a log with these arguments writes to stderr's stand-in while `speak` runs.
template <typename Speak>
std::string Written(const OutputArguments& arguments, const char* levels, Speak&& speak) {
    std::FILE* file = std::tmpfile();
    {
        Progress progress(file, arguments.isQuiet);
        ProgramLog log(arguments, levels, progress);
        speak(log);
    }
    std::string text(static_cast<size_t>(std::ftell(file)), '\0');
    std::rewind(file);
    text.resize(std::fread(text.data(), 1, text.size(), file));
    std::fclose(file);
    return text;
}

void SpeakOfAll(ProgramLog& log) {
    const Log library = log.ForLibraries();
    library.Send(LogLevel::Debug, log_category::kShaders, "a pipeline");
    library.Send(LogLevel::Info, log_category::kScene, "a scene");
    library.Send(LogLevel::Warning, log_category::kMemory, "little memory");
    log.Warn("no light");
    log.Fail("a.gltf: is broken");
}

TEST(ProgramLog, WarningsAreShownAndMoreIfItIsAskedFor) {
    const std::string warnings =
        "raygraph: warning: little memory\nraygraph: warning: no light\nraygraph: a.gltf: is broken\n";
    const std::string scene = "raygraph: info: [scene] a scene\n";
    const std::string pipeline = "raygraph: debug: [shaders] a pipeline\n";
    EXPECT_EQ(Written({}, nullptr, SpeakOfAll), warnings);
    EXPECT_EQ(Written({}, "", SpeakOfAll), warnings);
    EXPECT_EQ(Written({.verbosity = 1}, nullptr, SpeakOfAll), scene + warnings);
    EXPECT_EQ(Written({.verbosity = 2}, nullptr, SpeakOfAll), pipeline + scene + warnings);
    EXPECT_EQ(Written({}, "info", SpeakOfAll), scene + warnings);
    EXPECT_EQ(Written({}, "shaders=debug", SpeakOfAll), pipeline + warnings);
    EXPECT_EQ(Written({.verbosity = 1}, "scene=off", SpeakOfAll), warnings);
    EXPECT_EQ(Written({}, "off", SpeakOfAll), "raygraph: a.gltf: is broken\n")
        << "why it ended is always said";
    EXPECT_EQ(Written({.isQuiet = true}, "debug", SpeakOfAll), "raygraph: a.gltf: is broken\n");
}

TEST(ProgramLog, WithoutAListenerLibrariesMakeNoInformation) {
    Written({}, nullptr, [](ProgramLog& log) {
        EXPECT_FALSE(log.ForLibraries().IsEnabled(LogLevel::Info));
        EXPECT_TRUE(log.ForLibraries().IsEnabled(LogLevel::Warning));
        log.AddListener([](const LogMessage&) {});
        EXPECT_TRUE(log.ForLibraries().IsEnabled(LogLevel::Info));
        EXPECT_FALSE(log.ForLibraries().IsEnabled(LogLevel::Debug));
    });
}

TEST(ProgramLog, BadLevelsNameTheVariable) {
    ExpectError(
        ErrorKind::BadInput, [] { Written({}, "loud", SpeakOfAll); }, "RAYGRAPH_LOG", "\"loud\"");
}

TEST(ProgramLog, FileAndListenerHaveInformationToo) {
    const TemporaryFolder folder;
    std::string heard;
    std::ofstream(folder.Path() / "a.log") << "before\n";
    Written({.isQuiet = true, .logFile = folder.Path() / "a.log"}, nullptr, [&](ProgramLog& log) {
        log.AddListener([&](const LogMessage& message) { (heard += message.text) += '|'; });
        SpeakOfAll(log);
    });
    EXPECT_EQ(heard, "a scene|little memory|no light|");
    std::ifstream file(folder.Path() / "a.log");
    std::string line;
    std::getline(file, line);
    EXPECT_EQ(line, "before") << "it is added to";
    for (const char* expected : {"info    scene      a scene", "warning memory     little memory",
                                 "warning program    no light", "error   program    a.gltf: is broken"}) {
        std::getline(file, line);
        EXPECT_NE(line.find(expected), std::string::npos) << line << " lacks " << expected;
    }
    EXPECT_FALSE(std::getline(file, line)) << line;
}

TEST(ProgramLog, FileThatCannotBeOpenedIsAnOutputError) {
    const TemporaryFolder folder;
    ExpectError(
        ErrorKind::Io, [&] { Written({.logFile = folder.Path()}, nullptr, SpeakOfAll); }, "--log: ");
}

TEST(ProgramLog, FullDiskIsOneLine) {
    const std::string text = Written({.logFile = "/dev/full"}, nullptr, [](ProgramLog& log) {
        SpeakOfAll(log);
        log.Warn("again");
        log.Fail("b.gltf: is broken");
    });
    EXPECT_EQ(text.find("the log is not complete"), text.rfind("the log is not complete")) << text;
    EXPECT_TRUE(text.starts_with("raygraph: warning: the log is not complete: ")) << text;
    EXPECT_EQ(std::ranges::count(text, '\n'), 6) << text;
}

TEST(ProgramLog, FullDiskIsOneLineForTheErrorThatEndsTheProgramToo) {
    ::testing::internal::CaptureStderr();
    const std::string text =
        Written({.logFile = "/dev/full"}, nullptr, [](ProgramLog& log) { log.Fail("a.gltf: is broken"); });
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_TRUE(text.starts_with("raygraph: a.gltf: is broken\nraygraph: warning: the log is not complete: "))
        << text;
    EXPECT_EQ(std::ranges::count(text, '\n'), 2) << text;
}

TEST(ProgramLog, ValidationMessagesFailTheRunAndAreShownToWhoAsks) {
    const auto speak = [](ProgramLog& log) {
        log.RequireValid();
        log.ForLibraries().Send(LogLevel::Error, log_category::kValidation, "VUID-1:\nit is wrong");
        log.ForLibraries().Send(LogLevel::Warning, log_category::kValidation, "VUID-2");
        ExpectError(
            ErrorKind::Vulkan, [&] { log.RequireValid(); }, "validation: VUID-1: it is wrong (and 1 more)");
        log.RequireValid();  // these were already reported
    };
    EXPECT_EQ(Written({}, nullptr, speak), "");
    EXPECT_EQ(Written({.verbosity = 1}, nullptr, speak),
              "raygraph: error: VUID-1: it is wrong\nraygraph: warning: VUID-2\n");
    EXPECT_EQ(Written({}, "warning,validation=error", speak), "raygraph: error: VUID-1: it is wrong\n");
}

TEST(ProgramLog, LinesOfManyThreadsStayWhole) {
    constexpr int kLines = 200;
    const std::string text = Written({.verbosity = 1}, nullptr, [](ProgramLog& log) {
        const Log library = log.ForLibraries();
        const auto speak = [&] {
            for (int i = 0; i < kLines; ++i) library.Send(LogLevel::Info, log_category::kScene, "word word");
        };
        std::thread other(speak), third(speak);
        speak();
        other.join();
        third.join();
    });
    std::string expected;
    for (int i = 0; i < 3 * kLines; ++i) expected += "raygraph: info: [scene] word word\n";
    EXPECT_EQ(text, expected);
}

}  // namespace
}  // namespace raygraph::cli::program_log_test
