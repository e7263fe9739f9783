#include "editor/cli/outputs.h"

#include <unistd.h>

#include <fstream>

#include "tests/cli/cli_test.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::cli {
namespace {

using Paths = std::vector<std::filesystem::path>;

size_t FileCount(const std::filesystem::path& folder) {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(Outputs, CheckingLeavesNoTrace) {
    const test::TemporaryFolder folder;
    const std::filesystem::path old = folder.Path() / "old.png";
    std::ofstream(old) << "old";
    CheckWritable(Paths{folder.Path() / "new.png", old}, {});
    EXPECT_EQ(FileCount(folder.Path()), 1u);
    EXPECT_EQ(std::filesystem::file_size(old), 3u);
}

TEST(Outputs, AMissingFolderIsNamed) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "none" / "a.png";
    test::ExpectError(
        ErrorKind::Io, [&] { CheckWritable(Paths{path}, {}); }, path.string(), "no folder");
}

TEST(Outputs, AFolderIsNoOutput) {
    const test::TemporaryFolder folder;
    std::filesystem::create_directory(folder.Path() / "a.png");
    test::ExpectError(
        ErrorKind::Io, [&] { CheckWritable(Paths{folder.Path() / "a.png"}, {}); }, "a.png");
}

TEST(Outputs, AFolderThatIsClosedToUsIsRefused) {
    if (geteuid() == 0) GTEST_SKIP() << "nothing is closed to root";
    const test::TemporaryFolder folder;
    std::filesystem::permissions(folder.Path(),
                                 std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    test::ExpectError(
        ErrorKind::Io, [&] { CheckWritable(Paths{folder.Path() / "a.png"}, {}); }, "a.png");
}

TEST(Outputs, OneFileUnderTwoNamesIsRefused) {
    const test::TemporaryFolder folder;
    test::ExpectError(
        ErrorKind::Usage,
        [&] {
            CheckWritable(Paths{folder.Path() / "a.png", folder.Path() / "." / "a.png"}, {});
        },
        "twice");
}

TEST(Outputs, AnInputIsNotOverwritten) {
    const test::TemporaryFolder folder;
    const std::filesystem::path sky = folder.Path() / "sky.hdr";
    std::ofstream(sky) << "x";
    std::filesystem::create_symlink(sky, folder.Path() / "link.hdr");
    test::ExpectError(
        ErrorKind::Usage, [&] { CheckWritable(Paths{folder.Path() / "link.hdr"}, Paths{sky}); }, "link.hdr",
        "read");
}

}  // namespace
}  // namespace raygraph::cli
