// Tests how commands end: exit status and last lines, and the files that they name.
#include "editor/cli/commands.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "tests/cli/cli_test.h"
#include "tests/support/temporary_folder.h"

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
