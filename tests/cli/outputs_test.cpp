#include "editor/cli/outputs.h"

#include <fcntl.h>
#include <linux/fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <new>

#include "base/files.h"
#include "tests/cli/cli_test.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::cli::outputs_test {
namespace {

using test::FileCount;

using Paths = std::vector<std::filesystem::path>;

TEST(Outputs, CheckingLeavesNoTrace) {
    const test::TemporaryFolder folder;
    const std::filesystem::path old = folder.Path() / "old.png";
    std::ofstream(old) << "old";
    CheckOutputs(Paths{folder.Path() / "new.png", old}, {});
    EXPECT_EQ(FileCount(folder.Path()), 1u);
    EXPECT_EQ(std::filesystem::file_size(old), 3u);
}

TEST(Outputs, ANameThatIsTooLongIsRefusedBeforeTheWork) {
    const test::TemporaryFolder folder;
    // A name that is too long beside a valid one: a sequence may have a long number or camera in its names
    std::string name = ".png";
    name.insert(0, 300, 'a');
    const Paths paths{folder.Path() / "a.png", folder.Path() / name};
    test::ExpectError(
        ErrorKind::Io, [&] { CheckOutputs(paths, {}); }, "cannot write: File name too long");
}

// Covers /dev/stdout, and the pipes that a shell makes of >(program).
TEST(Outputs, DevicesAndPipesAreTakenWithoutTouchingThem) {
    const test::TemporaryFolder folder;
    const std::filesystem::path pipe = folder.Path() / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_TRUE(CheckOutputs(Paths{"/dev/null", pipe}, {}).empty());
}

TEST(Outputs, OneThatCannotBeWrittenKeepsNoOther) {
    std::vector<std::string> said;
    OutputWriter outputs([&](const std::filesystem::path& file, std::string_view why) {
        said.push_back(file.string() + ": " + std::string(why));
    });
    outputs.Add("a", [] {});
    outputs.Add("b", [] { throw Error(ErrorKind::Io, "the disk is full"); });
    outputs.Add("c", [] { throw std::bad_alloc(); });
    outputs.Add("d", [] { throw IncompleteFile(ErrorKind::Io, "the disk is broken"); });
    outputs.Add("e", [] {});
    outputs.WriteAll();
    EXPECT_EQ(outputs.Written(), (Paths{"a", "e"}));
    EXPECT_EQ(said,
              (std::vector<std::string>{"b: the disk is full", "c: out of memory", "d: the disk is broken"}));
    EXPECT_EQ(outputs.Result(), ExitCode::Failure) << "that of the first";
    for (const char* name : {"a", "b", "c", "d", "e"}) {
        EXPECT_EQ(outputs.HasWritten(name), *name == 'a' || *name == 'e') << name;
        EXPECT_EQ(outputs.IsTorn(name), *name == 'd') << name;
    }
}

// The reader of a stream may never come.
TEST(Outputs, DevicesAndPipesAreWrittenAfterAllFiles) {
    const test::TemporaryFolder folder;
    const std::filesystem::path pipe = folder / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    OutputWriter outputs([](const std::filesystem::path&, std::string_view) {});
    for (const std::filesystem::path& file : Paths{pipe, "a", "/dev/null", "b"}) outputs.Add(file, [] {});
    outputs.WriteAll();
    EXPECT_EQ(outputs.Written(), (Paths{"a", "b", pipe, "/dev/null"}));
}

// A file that is written in place, a stream and a link tell nothing about whether their folder takes new
// files.
TEST(Outputs, ANewFileIsRefusedWhateverCouldBeWrittenBesideIt) {
    const test::TemporaryFolder folder, elsewhere;
    const std::filesystem::path mounted = folder / "mounted.png", pipe = folder / "pipe",
                                link = folder / "link";
    std::ofstream(mounted) << "old";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    std::filesystem::create_symlink(elsewhere / "a.png", link);
    // The immutable folder takes no new files; the link's folder does.
    const int descriptor = open(folder.Path().c_str(), O_RDONLY | O_DIRECTORY);
    int flags = FS_IMMUTABLE_FL;
    const bool isFixed = ioctl(descriptor, FS_IOC_SETFLAGS, &flags) == 0;
    for (const std::filesystem::path& first : isFixed ? Paths{mounted, pipe, link} : Paths{}) {
        SCOPED_TRACE(first);
        const Paths paths{first, folder / "b.png"};
        test::ExpectError(
            ErrorKind::Io, [&] { CheckOutputs(paths, {}); }, "b.png: cannot create a file in its folder");
    }
    flags = 0;
    ioctl(descriptor, FS_IOC_SETFLAGS, &flags);
    close(descriptor);
    if (!isFixed) GTEST_SKIP() << "a file cannot be made immutable here";
}

TEST(Outputs, AMissingFolderIsNamed) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "none" / "a.png";
    test::ExpectError(
        ErrorKind::Io, [&] { CheckOutputs(Paths{path}, {}); }, path.string(), "no folder");
}

TEST(Outputs, AFolderIsNoOutput) {
    const test::TemporaryFolder folder;
    std::filesystem::create_directory(folder.Path() / "a.png");
    test::ExpectError(
        ErrorKind::Io, [&] { CheckOutputs(Paths{folder.Path() / "a.png"}, {}); }, "a.png");
}

TEST(Outputs, AFolderThatIsClosedToUsIsRefused) {
    if (geteuid() == 0) GTEST_SKIP() << "nothing is closed to root";
    const test::TemporaryFolder folder;
    std::filesystem::permissions(folder.Path(),
                                 std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    test::ExpectError(
        ErrorKind::Io, [&] { CheckOutputs(Paths{folder.Path() / "a.png"}, {}); }, "a.png");
}

TEST(Outputs, OneFileUnderTwoNamesIsRefused) {
    const test::TemporaryFolder folder;
    test::ExpectError(
        ErrorKind::Usage,
        [&] {
            CheckOutputs(Paths{folder.Path() / "a.png", folder.Path() / "." / "a.png"}, {});
        },
        "twice");
}

TEST(Outputs, AnInputIsNotOverwritten) {
    const test::TemporaryFolder folder;
    const std::filesystem::path sky = folder.Path() / "sky.hdr";
    std::ofstream(sky) << "x";
    std::filesystem::create_symlink(sky, folder.Path() / "link.hdr");
    test::ExpectError(
        ErrorKind::Usage, [&] { CheckOutputs(Paths{folder.Path() / "link.hdr"}, Paths{sky}); }, "link.hdr",
        "read");
}

// Returns the paths "f.0.png", "f.1.png" and so on in the folder.
Paths Sequence(const std::filesystem::path& folder, int count) {
    Paths paths;
    for (int i = 0; i < count; ++i) paths.push_back(folder / ("f." + std::to_string(i) + ".png"));
    return paths;
}

// This holds whatever is wrong with the name: the ones before it in the folder are valid.
TEST(Outputs, OneOfASequenceIsRefusedAsItWouldBeAlone) {
    const test::TemporaryFolder folder;
    const Paths paths = Sequence(folder.Path(), 20);
    const std::filesystem::path input = folder.Path() / "scene.gltf";
    std::ofstream(input) << "x";
    std::ofstream(paths[3]) << "old";
    EXPECT_EQ(testing::ErrorTextOf([&] { CheckOutputs(paths, Paths{input}); }), "accepted");
    const auto refused = [&](ErrorKind kind, const std::string& what) {
        test::ExpectError(
            kind, [&] { CheckOutputs(paths, Paths{input}); }, what);
        std::filesystem::remove(paths[7]);
    };
    std::filesystem::create_symlink(paths[3], paths[7]);
    refused(ErrorKind::Usage, "f.7.png is to be written twice");
    std::filesystem::create_symlink(input, paths[7]);
    refused(ErrorKind::Usage, "f.7.png is to be read and to be written");
    std::filesystem::create_symlink(folder.Path() / "none" / "f.png", paths[7]);
    refused(ErrorKind::Io, "cannot create a file in its folder");
    std::filesystem::create_directory(paths[7]);
    refused(ErrorKind::Io, "f.7.png: cannot write: it is a folder");
    EXPECT_EQ(FileCount(folder.Path()), 2u);
}

TEST(Outputs, OneFolderUnderTwoNamesIsOne) {
    const test::TemporaryFolder folder;
    std::filesystem::create_directory(folder.Path() / "a");
    std::filesystem::create_directory_symlink("a", folder.Path() / "b");
    Paths paths = Sequence(folder.Path() / "a", 3);
    paths.push_back(folder.Path() / "b" / "f.1.png");
    test::ExpectError(
        ErrorKind::Usage, [&] { CheckOutputs(paths, {}); }, "b/f.1.png is to be written twice");
    test::ExpectError(
        ErrorKind::Usage, [&] { CheckLogFile(paths.back(), Paths{paths[1]}, {}); },
        "b/f.1.png is to be written twice");
    EXPECT_EQ(FileCount(folder.Path() / "a"), 0u);
}

// Creating and removing a file for each name would take ten times as long.
TEST(Outputs, ALongSequenceIsCheckedInAFractionOfASecond) {
    const test::TemporaryFolder folder;
    const Paths paths = Sequence(folder.Path(), 100'000);
    const auto start = std::chrono::steady_clock::now();
    CheckOutputs(paths, {});
    CheckLogFile(folder.Path() / "log", paths, {});
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    RecordProperty("seconds", std::to_string(taken.count()));
    EXPECT_LT(taken.count(), 5.0);
}

}  // namespace
}  // namespace raygraph::cli::outputs_test
