#include <fcntl.h>
#include <gmock/gmock.h>
#include <pty.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <thread>

#include "editor/cli/commands.h"
#include "editor/cli/program_log.h"
#include "editor/cli/progress.h"
#include "editor/cli/run_command.h"
#include "tests/cli/cli_test.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::cli::progress_test {
namespace {

TEST(Progress, LineShowsWhatIsKnown) {
    EXPECT_EQ(FormatProgress({128, 256, 1.234e6, 0.0179, 12.2}),
              "  128/256 samples  1.23 Msamples/s  error 1.8 %  12 s left");
    ProgressState restoring{128, 256, 1.234e6, 0.0179, 12.2};
    restoring.samplesRestored = 12;
    EXPECT_EQ(FormatProgress(restoring), "  restoring albedo and normals  12/128 samples");
    EXPECT_EQ(FormatProgress({1, 1, 0.0, std::nullopt, std::nullopt}), "  1/1 sample");
    EXPECT_EQ(FormatProgress({1, 2, 0.0, std::nullopt, std::nullopt}), "  1/2 samples");
    EXPECT_EQ(FormatProgress({1, std::nullopt, 0.0, std::nullopt, std::nullopt}), "  1 sample");
    EXPECT_EQ(FormatProgress({3, std::nullopt, 0.0, std::nullopt, std::nullopt}), "  3 samples");
}

TEST(Progress, WritesNothingToAFile) {
    std::FILE* file = std::tmpfile();
    ASSERT_NE(file, nullptr);
    {
        Progress progress(file, false);
        EXPECT_FALSE(progress.IsOn());
        progress.ShowStep("x");
    }
    EXPECT_EQ(std::ftell(file), 0);
    std::fclose(file);
}

// Simulates a terminal of 40 columns that records what was written to it.
class Terminal {
  public:
    Terminal() {
        const winsize size{.ws_row = 10, .ws_col = 40, .ws_xpixel = 0, .ws_ypixel = 0};
        int inside = -1;
        if (openpty(&m_outside, &inside, nullptr, nullptr, &size) == 0) m_stream = fdopen(inside, "w");
    }
    ~Terminal() {
        if (m_stream) std::fclose(m_stream);
        close(m_outside);
    }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    std::FILE* Stream() const { return m_stream; }
    // Returns what was written since the last call as lines, each with what overwrote it. Text arrives in
    // pieces with a delay, so a mark after it tells that everything is here.
    std::string Shown() {
        constexpr char kMark = '\x1f';
        std::fputc(kMark, m_stream);
        std::fflush(m_stream);
        std::string text;
        std::array<char, 4096> buffer{};
        while (!text.ends_with(kMark)) {
            const ssize_t count = read(m_outside, buffer.data(), buffer.size());
            if (count <= 0) return text + " and no more";
            text.append(buffer.data(), static_cast<size_t>(count));
        }
        text.pop_back();
        std::string shown, line;
        size_t column = 0;
        for (const char c : text) {
            if (c == '\r') {
                column = 0;
            } else if (c == '\n') {
                shown += Trimmed(line) + "\n";
                line.clear();
            } else {
                line.resize(std::max(line.size(), column + 1), ' ');
                line[column++] = c;
            }
        }
        return shown + Trimmed(line);
    }

  private:
    static std::string Trimmed(const std::string& line) {
        return line.substr(0, line.find_last_not_of(' ') + 1);
    }

    int m_outside = -1;
    std::FILE* m_stream = nullptr;
};

TEST(Progress, LineIsBelowWhatIsPrintedAboveIt) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), false);
    ASSERT_TRUE(progress.IsOn());
    progress.PrintAboveProgress("first\n");
    EXPECT_EQ(terminal.Shown(), "first\n") << "there is no line yet";
    progress.ShowSamples("", {.samplesDone = 3});
    progress.PrintAboveProgress("second\n");
    progress.PrintAboveProgress("third\n");
    EXPECT_EQ(terminal.Shown(), "second\nthird\n  3 samples");
    progress.ShowStep("4");
    EXPECT_EQ(terminal.Shown(), "  4") << "nothing is left of the longer one";
    progress.Clear();
    progress.PrintAboveProgress("fourth\n");
    EXPECT_EQ(terminal.Shown(), "fourth\n");
}

TEST(Progress, LineThatIsWiderThanTheTerminalIsCut) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), false);
    progress.ShowStep(std::string(100, 'x'));
    EXPECT_EQ(terminal.Shown(), "  " + std::string(37, 'x'));
    progress.PrintAboveProgress("above\n");
    EXPECT_EQ(terminal.Shown(), "above\n  " + std::string(37, 'x'));
}

TEST(Progress, IsRedrawnFiveTimesASecondAtMost) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), false);
    const auto since = [](const auto& start) { return std::chrono::steady_clock::now() - start; };
    bool wasInTime = false;
    while (!wasInTime) {  // on a busy machine, the second state may come too late
        progress.Clear();
        const auto start = std::chrono::steady_clock::now();
        progress.ShowLoading("meshes", 0.1f);
        progress.ShowLoading("meshes", 0.2f);
        wasInTime = since(start) < std::chrono::milliseconds(200);
        const std::string shown = terminal.Shown();
        EXPECT_TRUE(shown == "  loading meshes  10 %" || !wasInTime) << shown;
    }
    progress.ShowLoading("images", 0.5f);
    EXPECT_EQ(terminal.Shown(), "  loading images  50 %") << "another stage is shown at once";
    std::this_thread::sleep_for(std::chrono::milliseconds(210));
    progress.ShowLoading("images", 0.6f);
    EXPECT_EQ(terminal.Shown(), "  loading images  60 %");
}

TEST(Progress, QuietMeansOffOnATerminalToo) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), true);
    progress.ShowStep("x");
    progress.PrintAboveProgress("above\n");
    EXPECT_EQ(terminal.Shown(), "above\n");
}

// Returns what `show` makes a Progress of this style write to a file.
template <typename Show>
std::string WrittenBy(ProgressStyle style, Show&& show) {
    std::FILE* file = std::tmpfile();
    {
        Progress progress(file, false, style);
        EXPECT_EQ(progress.IsOn(), style != ProgressStyle::None);
        show(progress);
    }
    std::string text(static_cast<size_t>(std::ftell(file)), '\0');
    std::rewind(file);
    text.resize(std::fread(text.data(), 1, text.size(), file));
    std::fclose(file);
    return text;
}

// Shows two runs of 40 samples in less time than the interval between two lines.
void ShowTwoRuns(Progress& progress) {
    progress.ShowLoading("file", 0.0f);
    for (const char* picture : {"  frame 1 of 2", "  frame 2 of 2"}) {
        for (uint32_t i = 1; i <= 40; ++i) {
            ProgressState state{i, 40, 0.0, std::nullopt, std::nullopt};
            if (i > 1) state = {i, 40, 2e6, 0.25, 0.5 * (40 - i)};
            progress.ShowSamples(picture, state);
        }
        progress.Clear();
        const std::filesystem::path files[] = {"a.png", "b.exr"};
        progress.ShowWritten(picture, files);
    }
    progress.ShowStep("  tidying up");
}

TEST(Progress, JsonHasTheFirstAndTheLastStateOfEachRun) {
    EXPECT_EQ(WrittenBy(ProgressStyle::Json, ShowTwoRuns),
              R"({"event":"loading","stage":"file","fraction":0.0}
{"event":"progress","picture":"frame 1 of 2","samples":1,"samples_wanted":40,"samples_per_second":null,"relative_error":null,"seconds_left":null}
{"event":"progress","picture":"frame 1 of 2","samples":40,"samples_wanted":40,"samples_per_second":2000000.0,"relative_error":0.25,"seconds_left":0.0}
{"event":"written","picture":"frame 1 of 2","files":["a.png","b.exr"]}
{"event":"progress","picture":"frame 2 of 2","samples":1,"samples_wanted":40,"samples_per_second":null,"relative_error":null,"seconds_left":null}
{"event":"progress","picture":"frame 2 of 2","samples":40,"samples_wanted":40,"samples_per_second":2000000.0,"relative_error":0.25,"seconds_left":0.0}
{"event":"written","picture":"frame 2 of 2","files":["a.png","b.exr"]}
{"event":"step","step":"tidying up"}
)");
}

TEST(Progress, PlainLinesAreForPeopleWhoReadALog) {
    EXPECT_EQ(WrittenBy(ProgressStyle::Plain, ShowTwoRuns),
              "raygraph: loading file, 0 %\n"
              "raygraph: frame 1 of 2, 1/40 samples\n"
              "raygraph: frame 1 of 2, 40/40 samples, 2 Msamples/s, error 25 %\n"
              "raygraph: frame 2 of 2, 1/40 samples\n"
              "raygraph: frame 2 of 2, 40/40 samples, 2 Msamples/s, error 25 %\n"
              "raygraph: tidying up\n");
    EXPECT_EQ(WrittenBy(ProgressStyle::None, ShowTwoRuns), "");
}

TEST(Progress, TheLastStateOfAStageStandsBeforeTheNext) {
    const auto show = [](Progress& progress) {
        for (const float fraction : {0.25f, 0.5f, 1.0f}) progress.ShowLoading("images", fraction);
        progress.ShowStep("  building");
    };
    EXPECT_EQ(WrittenBy(ProgressStyle::Plain, show),
              "raygraph: loading images, 25 %\nraygraph: loading images, 100 %\nraygraph: building\n");
}

TEST(Progress, JsonIsWrittenOnceASecond) {
    const auto start = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    const std::string text = WrittenBy(ProgressStyle::Json, [&](Progress& progress) {
        for (uint32_t i = 1; seconds() < 1.3; ++i) {
            progress.ShowSamples("", {.samplesDone = i});
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
    });
    const auto count = static_cast<double>(std::ranges::count(text, '\n'));
    EXPECT_GE(count, 3.0) << "the first, one after a second, the last\n" << text;
    EXPECT_LE(count, 2.0 + seconds()) << text;
}

TEST(Progress, JsonIsUtf8WhateverTheNamesAre) {
    const std::string text = WrittenBy(ProgressStyle::Json, [](Progress& progress) {
        const std::filesystem::path files[] = {"a\xff \"b\".png"};
        progress.ShowWritten("", files);
    });
    EXPECT_EQ(text, "{\"event\":\"written\",\"files\":[\"a\xEF\xBF\xBD \\\"b\\\".png\"]}\n");
}

TEST(Progress, RestoringIsAnEventOfItsOwn) {
    EXPECT_EQ(WrittenBy(ProgressStyle::Json,
                        [](Progress& progress) {
                            ProgressState state{.samplesDone = 16};
                            state.samplesRestored = 3;
                            progress.ShowSamples("", state);
                        }),
              "{\"event\":\"restoring\",\"samples\":3,\"samples_wanted\":16}\n");
}

}  // namespace
}  // namespace raygraph::cli::progress_test

// Tests levels, and the targets of messages: stderr, a file, a listener.
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

// Tests how commands end: exit status and last lines, and the files that they name.
namespace raygraph::cli::run_command_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Stands for a device for which the layers report something when it is destroyed.
class InvalidAtItsEnd {
  public:
    explicit InvalidAtItsEnd(Log log) : m_log(std::move(log)) {}
    ~InvalidAtItsEnd() { m_log.Send(LogLevel::Error, log_category::kValidation, "VUID-9: a leak"); }
    InvalidAtItsEnd(const InvalidAtItsEnd&) = delete;
    InvalidAtItsEnd& operator=(const InvalidAtItsEnd&) = delete;

  private:
    Log m_log;
};

struct Ended {
    ExitCode code;
    std::string messages;
};

template <typename Command>
Ended EndOf(Command&& command) {
    ::testing::internal::CaptureStderr();
    const ExitCode code = RunCommand(InfoArguments{}, command);
    return {code, ::testing::internal::GetCapturedStderr()};
}

TEST(RunCommand, StatusIsTheCommandsOrThatOfItsError) {
    EXPECT_EQ(EndOf([](const auto&, Console&) { return ExitCode::Done; }).code, ExitCode::Done);
    EXPECT_EQ(EndOf([](const auto&, Console&) { return ExitCode::Slower; }).code, ExitCode::Slower);
    const Ended broken = EndOf(
        [](const auto&, Console&) -> ExitCode { throw Error(ErrorKind::BadInput, "a.gltf: is broken"); });
    EXPECT_EQ(broken.code, ExitCode::BadInput);
    EXPECT_EQ(broken.messages, "raygraph: a.gltf: is broken\n");
    const Ended full = EndOf([](const auto&, Console&) -> ExitCode { throw std::bad_alloc(); });
    EXPECT_EQ(full.code, ExitCode::DeviceFailure);
    EXPECT_EQ(full.messages, "raygraph: out of memory\n");
}

TEST(RunCommand, ValidationMessagesOfTheDevicesEndFailIt) {
    for (const ExitCode result : {ExitCode::Done, ExitCode::Slower}) {
        const Ended ended = EndOf([&](const auto&, Console& console) {
            const InvalidAtItsEnd device(console.log.ForLibraries());
            console.log.RequireValid();
            return result;
        });
        EXPECT_EQ(ended.code, ExitCode::Failure);
        EXPECT_EQ(ended.messages, "raygraph: validation: VUID-9: a leak\n");
    }
}

TEST(RunCommand, ErrorDoesNotHideValidationMessages) {
    const Ended ended = EndOf([](const auto&, Console& console) -> ExitCode {
        const InvalidAtItsEnd device(console.log.ForLibraries());
        throw Error(ErrorKind::DeviceLost, "the device is lost");
    });
    EXPECT_EQ(ended.code, ExitCode::DeviceFailure);
    EXPECT_EQ(ended.messages, "raygraph: the device is lost\nraygraph: validation: VUID-9: a leak\n");
}

TEST(RunCommand, ValidationMessagesAreSaidOnce) {
    const Ended ended = EndOf([](const auto&, Console& console) {
        { const InvalidAtItsEnd device(console.log.ForLibraries()); }
        console.log.RequireValid();
        return ExitCode::Done;
    });
    EXPECT_EQ(ended.code, ExitCode::Failure);
    EXPECT_EQ(ended.messages, "raygraph: validation: VUID-9: a leak\n");
}

// Redirects stdout to a file while it lives.
class StdoutTo {
  public:
    explicit StdoutTo(const char* file) : m_before(dup(STDOUT_FILENO)) {
        std::fflush(stdout);
        const int descriptor = open(file, O_WRONLY);
        dup2(descriptor, STDOUT_FILENO);
        close(descriptor);
    }
    ~StdoutTo() {
        std::fflush(stdout);
        std::clearerr(stdout);
        dup2(m_before, STDOUT_FILENO);
        close(m_before);
    }
    StdoutTo(const StdoutTo&) = delete;
    StdoutTo& operator=(const StdoutTo&) = delete;

  private:
    int m_before;
};

TEST(RunCommand, StdoutThatCannotBeWrittenFailsItUnlessTheWorkIsSaved) {
    const auto print = [](size_t bytes, ExitCode code) {
        const StdoutTo full("/dev/full");
        return EndOf([&](const auto&, Console&) {
            PrintLine(std::string(bytes, 'x'));
            return code;
        });
    };
    const Ended atTheEnd = print(10, ExitCode::Done);
    EXPECT_EQ(atTheEnd.code, ExitCode::Failure);
    EXPECT_EQ(atTheEnd.messages, "raygraph: stdout cannot be written: No space left on device\n");
    // The buffer is full long before the end, and flushing it fails
    const Ended before = print(1 << 20, ExitCode::Done);
    EXPECT_EQ(before.code, ExitCode::Failure);
    EXPECT_TRUE(before.messages.starts_with("raygraph: stdout cannot be written")) << before.messages;
    EXPECT_EQ(std::ranges::count(before.messages, '\n'), 1);
    EXPECT_EQ(print(10, ExitCode::TryAgain).code, ExitCode::TryAgain);
    EXPECT_EQ(print(0, ExitCode::BadInput).code, ExitCode::BadInput);
}

TEST(CommandFiles, HoldWhatIsGiven) {
    RenderArguments render;
    render.scene = "a.gltf";
    EXPECT_THAT(FilesOf(render).inputs, ElementsAre("a.gltf"));
    EXPECT_THAT(FilesOf(render).updated, IsEmpty());
    EXPECT_THAT(FilesOf(render).outputs, ElementsAre("render.png"));
    render.resume = "a.exr";
    EXPECT_THAT(FilesOf(render).outputs, ElementsAre("a.exr")) << "it is replaced";
    render.environment = "sky.hdr";
    render.report = "r.json";
    render.outputs = {{"a.png", OutputKind::Png}, {"b.exr", OutputKind::Exr}};
    EXPECT_THAT(FilesOf(render).inputs, ElementsAre("a.gltf", "sky.hdr"));
    EXPECT_THAT(FilesOf(render).updated, ElementsAre("a.exr"));
    EXPECT_THAT(FilesOf(render).outputs, ElementsAre("r.json", "a.png", "b.exr"));
}

TEST(CommandFiles, InputsAreNotWrittenButUpdatedOnesMayBe) {
    const test::TemporaryFolder folder;
    const std::filesystem::path scene = folder.Path() / "a.gltf", old = folder.Path() / "a.exr";
    std::ofstream(scene) << "scene";
    std::ofstream(old) << "render";
    BenchArguments bench;
    bench.scene = bench.environment = scene;
    bench.compare = old;
    bench.json = folder.Path() / "new.json";
    CheckWritable(FilesOf(bench), {});
    // The stored run has other scenes, too, which would be lost if this one were slower
    bench.json = old;
    const auto expectRefused = [&] {
        test::ExpectError(
            ErrorKind::Usage, [&] { CheckWritable(FilesOf(bench), {}); }, "to be read and to be written");
    };
    expectRefused();
    bench.compare.clear();
    CheckWritable(FilesOf(bench), {});
    bench.environment = old;
    expectRefused();
    MergeArguments merge;
    merge.inputs = {old};
    merge.output = old;
    CheckWritable(FilesOf(merge), {});
}

TEST(CommandFiles, ResumedRenderIsReplacedByARenderAlone) {
    const test::TemporaryFolder folder;
    const std::filesystem::path old = folder.Path() / "a.exr", named = folder.Path() / "a.png";
    for (const std::filesystem::path& file : {old, named}) std::ofstream(file) << "render";
    RenderArguments render;
    render.resume = old;
    CheckWritable(FilesOf(render), {});
    render.outputs = {{old, OutputKind::Exr}, {named, OutputKind::Png}};
    CheckWritable(FilesOf(render), {});
    const auto expectRefused = [&] {
        test::ExpectError(
            ErrorKind::Usage, [&] { CheckWritable(FilesOf(render), {}); }, render.resume.string(),
            "to be read and to be written");
    };
    render.resume = named;  // the kind of the resumed file does not matter
    expectRefused();
    render = {};
    render.resume = render.report = old;
    render.outputs = {{folder.Path() / "b.exr", OutputKind::Exr}};
    expectRefused();
}

}  // namespace
}  // namespace raygraph::cli::run_command_test
