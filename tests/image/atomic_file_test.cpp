#include "base/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <thread>

#include "base/error.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"
#include "tests/image/image_files.h"
#include "tests/support/failing_files.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::test::atomic_file_test {
namespace {

namespace fs = std::filesystem;

TEST(AtomicFile, Commit_ReplacesTheTargetAndLeavesNothingElse) {
    const TemporaryFolder folder;
    Put(folder / "out.txt", "old");
    AtomicFile file(folder / "out.txt");
    file.Write(ToBytes("new text"));
    EXPECT_EQ(TextOf(folder / "out.txt"), "old");
    file.Commit();
    EXPECT_EQ(TextOf(folder / "out.txt"), "new text");
    EXPECT_EQ(FileCount(folder.Path()), 1u);
}

TEST(AtomicFile, WithoutCommitTheTargetIsUntouched) {
    const TemporaryFolder folder;
    Put(folder / "out.txt", "old");
    {
        AtomicFile file(folder / "out.txt");
        file.Write(ToBytes("new text"));
    }
    EXPECT_EQ(TextOf(folder / "out.txt"), "old");
    EXPECT_EQ(FileCount(folder.Path()), 1u);
}

TEST(AtomicFile, Seek_OverwritesEarlierBytes) {
    const TemporaryFolder folder;
    AtomicFile file(folder / "out.txt");
    file.Write(ToBytes("....text"));
    file.Seek(0);
    file.Write(ToBytes("1234"));
    EXPECT_EQ(file.Position(), 4u);
    file.Commit();
    EXPECT_EQ(TextOf(folder / "out.txt"), "1234text");
}

TEST(AtomicFile, TwoWritersOfOneTargetDoNotMix) {
    const TemporaryFolder folder;
    const auto write = [&](char letter) {
        for (int i = 0; i < 50; ++i) {
            AtomicFile file(folder / "out.txt");
            file.Write(ToBytes(std::string(1000, letter)));
            file.Commit();
        }
    };
    std::thread other(write, 'b');
    write('a');
    other.join();
    const std::string text = TextOf(folder / "out.txt");
    EXPECT_EQ(text, std::string(1000, text.at(0)));
    EXPECT_EQ(FileCount(folder.Path()), 1u);
}

TEST(AtomicFile, ModeOfTheTargetIsKept) {
    const TemporaryFolder folder;
    Put(folder / "out.txt", "old");
    ASSERT_EQ(chmod((folder / "out.txt").c_str(), 0640), 0);
    AtomicFile file(folder / "out.txt");
    file.Commit();
    struct stat status = {};
    ASSERT_EQ(stat((folder / "out.txt").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, 0640u);
}

TEST(AtomicFile, SymbolicLinkIsFollowedAndStaysALink) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "real");
    Put(folder / "real/file.txt", "old");
    fs::create_symlink("real/file.txt", folder / "link.txt");
    AtomicFile file(folder / "link.txt");
    file.Write(ToBytes("new"));
    file.Commit();
    EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
    EXPECT_EQ(TextOf(folder / "real/file.txt"), "new");
}

TEST(AtomicFile, LinkToNothingYetIsFollowedAndALoopIsRefused) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "real");
    fs::create_symlink("second.txt", folder / "first.txt");
    fs::create_symlink(folder / "real/file.txt", folder / "second.txt");
    AtomicFile file(folder / "first.txt");
    file.Write(ToBytes("new"));
    file.Commit();
    EXPECT_TRUE(fs::is_symlink(folder / "first.txt"));
    EXPECT_EQ(TextOf(folder / "real/file.txt"), "new");

    fs::create_symlink("loop.txt", folder / "loop.txt");
    EXPECT_NE(IoError([&] { AtomicFile loop(folder / "loop.txt"); }).find("cannot follow the link"),
              std::string::npos);
    const std::string gone = folder / "none/file.txt", link = folder / "link.txt";
    fs::create_symlink(gone, link);
    EXPECT_EQ(
        IoError([&] { AtomicFile lost(link); }),
        link + ", a link to " + gone + ": cannot create a file in its folder: No such file or directory");
}

TEST(AtomicFile, BareFileNameIsWrittenToTheCurrentFolder) {
    const TemporaryFolder folder;
    const fs::path before = fs::current_path();
    fs::current_path(folder.Path());
    AtomicFile file("bare.txt");
    file.Write(ToBytes("here"));
    file.Commit();
    fs::current_path(before);
    EXPECT_EQ(TextOf(folder / "bare.txt"), "here");
}

TEST(AtomicFile, MissingFolderIsNamedWithTheReason) {
    const TemporaryFolder folder;
    const fs::path path = folder / "missing/out.txt";
    const std::string message = IoError([&] { AtomicFile file(path); });
    EXPECT_EQ(message, path.string() + ": cannot create a file in its folder: No such file or directory");
}

TEST(AtomicFile, FoldersAreRefused) {
    const TemporaryFolder folder;
    EXPECT_EQ(IoError([&] { AtomicFile file(folder.Path()); }),
              folder.Path().string() + ": cannot write: it is a folder");
}

TEST(AtomicFile, NameThatCannotBeIsRefusedAndTheLongestIsTaken) {
    const TemporaryFolder folder;
    const fs::path tooLong = folder / std::string(300, 'x');
    EXPECT_EQ(IoError([&] { AtomicFile file(tooLong); }),
              tooLong.string() + ": cannot write: File name too long");
    const fs::path longest = folder / std::string(255, 'x');
    for (const std::string text : {"new", "newer"}) {
        AtomicFile file(longest);
        file.Write(ToBytes(text));
        file.Commit();
        EXPECT_EQ(TextOf(longest), text);
    }
}

// A path of 4095 bytes is the longest possible, and leaves no room for another name.
TEST(AtomicFile, LongestPathIsTaken) {
    const TemporaryFolder folder;
    fs::path path = folder.Path();
    while (path.native().size() < 4095 - 202) path /= std::string(200, 'd');
    path /= std::string(4095 - 3 - path.native().size() - 1, 'd');
    fs::create_directories(path);
    path /= "a";
    ASSERT_EQ(path.native().size(), 4094u);
    AtomicFile file(path);
    file.Write(ToBytes("text"));
    file.Commit();
    EXPECT_EQ(TextOf(path), "text");
}

// Every writer is tested on a disk that fills up early, in the middle, and at the last byte.
TEST(Writers, AFailingWriteLeavesTheOldFileAndNoOther) {
    const TemporaryFolder folder;
    const image::Image8 image8 = Pattern(300, 200);
    image::ImageF imageF{300, 200, std::vector<float>(size_t{4} * 300 * 200)};
    for (size_t i = 0; i < imageF.rgba.size(); ++i)
        imageF.rgba[i] = static_cast<float>(i * 2654435761u % 1000003);
    const image::ExrPlane plane{"R", std::span<const float>(imageF.rgba), 4};
    const std::function<void(const fs::path&)> writers[] = {
        [&](const fs::path& path) { image::WritePng(path, image8); },
        [&](const fs::path& path) { image::WriteHdr(path, imageF); },
        [&](const fs::path& path) { image::WriteExr(path, 300, 200, std::span(&plane, 1)); },
    };
    const fs::path path = folder / "picture";
    for (const auto& write : writers) {
        fs::remove(path);
        write(path);
        const auto size = fs::file_size(path);
        ASSERT_GT(size, 15000u);
        Put(path, "old");
        for (const auto limit : {rlim_t{0}, rlim_t{10000}, static_cast<rlim_t>(size - 1)}) {
            const testing::FileSizeLimit full(limit);
            EXPECT_EQ(IoError([&] { write(path); }), path.string() + ": cannot write: File too large");
            EXPECT_EQ(TextOf(path), "old");
            EXPECT_EQ(FileCount(folder.Path()), 1u);
        }
    }
}

TEST(ReadFile, FailuresAreNamedWithTheReason) {
    const TemporaryFolder folder;
    Put(folder / "ten", "0123456789");
    EXPECT_EQ(ReadFile(folder / "ten", 10), ToBytes("0123456789"));
    const std::string path = (folder / "ten").string();
    EXPECT_EQ(Refusal(path, [&] { ReadFile(path, 9); }), path + ": 10 bytes exceed the limit of 9");
    const std::string missing = (folder / "none").string();
    EXPECT_EQ(IoError([&] { ReadFile(missing); }), missing + ": cannot open: No such file or directory");
    EXPECT_NE(IoError([&] { ReadFile(folder.Path()); }).find("not a regular file"), std::string::npos);
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    EXPECT_NE(IoError([&] { ReadFile(folder / "pipe"); }).find("not a regular file"), std::string::npos);
}

}  // namespace
}  // namespace raygraph::test::atomic_file_test
