// Files that are written whole or not at all.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <linux/fs.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>

#include "base/error.h"
#include "base/files.h"
#include "base/os.h"
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

// Tests AtomicFile if a target cannot be replaced, or the system lacks something else, and after processes
// that were killed.
namespace raygraph::test::atomic_file_system_test {
namespace {

TEST(AtomicFile, DeviceIsWrittenTo) {
    AtomicFile file("/dev/null");
    EXPECT_EQ(file.InPlaceReason(), "");
    file.Seek(4);
    file.Write(ToBytes("text"));
    file.Commit();
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    AtomicFile full("/dev/full");
    full.Write(ToBytes("text"));
    EXPECT_EQ(IoError([&] { full.Commit(); }), "/dev/full: cannot write: No space left on device");
}

TEST(AtomicFile, PipeGetsTheContentAsAWhole) {
    const TemporaryFolder folder;
    const fs::path pipe = folder / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    AtomicFile file(pipe);
    file.Write(ToBytes("....text"));
    file.Seek(0);
    file.Write(ToBytes("1234"));
    const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
    file.Commit();
    std::string text(20, '\0');
    text.resize(static_cast<size_t>(std::max<ssize_t>(read(reader, text.data(), text.size()), 0)));
    close(reader);
    EXPECT_EQ(text, "1234text");
    EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(AtomicFile, ReaderOfAPipeMayComeLateAndTakeItsTime) {
    const TemporaryFolder folder;
    const fs::path pipe = folder / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    // The content exceeds a pipe's buffer
    const std::string content(300'000, 'x');
    std::string text;
    std::thread reader([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        std::ifstream stream(pipe, std::ios::binary);
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        text.assign(std::istreambuf_iterator<char>(stream), {});
    });
    AtomicFile file(pipe);
    file.Write(ToBytes(content));
    const std::string said = IoError([&] { file.Commit(); });
    if (said != "accepted")
        close(open(pipe.c_str(), O_WRONLY | O_NONBLOCK));  // otherwise the reader waits forever
    reader.join();
    EXPECT_EQ(said, "accepted");
    EXPECT_EQ(text.size(), content.size());
    EXPECT_EQ(text, content);
}

// Otherwise the scheduler would kill it, and nobody would know what it has saved.
TEST(AtomicFile, ProcessThatIsAskedToEndWaitsForNoReader) {
    const TemporaryFolder folder;
    const fs::path pipe = folder / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    os::SignalWatch watch([] {});
    watch.StartDeferring();
    std::raise(SIGTERM);
    const auto refused = [&] {
        AtomicFile file(pipe);
        file.Write(ToBytes(std::string(300'000, 'x')));
        return IoError([&] { file.Commit(); });
    };
    const std::string unread = pipe.string() + ": cannot write: nobody reads the pipe";
    EXPECT_EQ(refused(), unread) << "there is no reader";
    const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
    EXPECT_EQ(refused(), unread) << "it does not read";
    close(reader);
}

// Returns what `work` returns in a process of its own; "" if that is killed.
template <typename Work>
std::string InChild(const Work& work) {
    int ends[2];
    if (pipe(ends) != 0) return "no pipe";
    const pid_t child = fork();
    if (child == 0) {
        const std::string said = work();
        (void)!write(ends[1], said.data(), said.size());
        _exit(0);
    }
    close(ends[1]);
    std::string said(4096, '\0');
    const ssize_t count = read(ends[0], said.data(), said.size());
    said.resize(count > 0 ? static_cast<size_t>(count) : 0);
    close(ends[0]);
    waitpid(child, nullptr, 0);
    return said;
}

std::string ReplaceInChild(const fs::path& path) {
    return InChild([&]() -> std::string {
        try {
            AtomicFile file(path);
            file.Write(ToBytes("new"));
            file.Commit();
            return "written, " + file.InPlaceReason();
        } catch (const Error& error) {
            return error.what();
        }
    });
}

constexpr uid_t kNobody = 65534;

// Root may replace everything, so this tests a user who owns nothing but the folder.
TEST(AtomicFile, OwnerOfASharedFolderReplacesFilesOfOthers) {
    if (geteuid() != 0) GTEST_SKIP() << "files of another user are made by root";
    const TemporaryFolder folder;
    const fs::path path = folder / "out.txt";
    Put(path, "old text");
    ASSERT_EQ(chmod(folder.Path().c_str(), 01777), 0);
    ASSERT_EQ(chown(folder.Path().c_str(), kNobody, kNobody), 0);
    EXPECT_EQ(InChild([&]() -> std::string {
                  if (setgid(kNobody) != 0 || setuid(kNobody) != 0) return "still root";
                  return ReplaceInChild(path);
              }),
              "written, ");
    EXPECT_EQ(TextOf(path), "new");
}

TEST(AtomicFile, FileOfAnotherUserInASharedFolderIsRefusedOrWrittenInPlace) {
    if (geteuid() != 0) GTEST_SKIP() << "files of another user are made by root";
    const TemporaryFolder folder;
    const fs::path path = folder / "out.txt";
    Put(path, "old text");
    ASSERT_EQ(chmod(folder.Path().c_str(), 01777), 0);
    const auto replaceAsNobody = [&] {
        return InChild([&]() -> std::string {
            if (setgid(kNobody) != 0 || setuid(kNobody) != 0) return "still root";
            return ReplaceInChild(path);
        });
    };
    ASSERT_EQ(chmod(path.c_str(), 0644), 0);
    EXPECT_EQ(replaceAsNobody(), path.string() + ": cannot replace: Operation not permitted");
    EXPECT_EQ(TextOf(path), "old text");
    ASSERT_EQ(chmod(path.c_str(), 0666), 0);
    EXPECT_EQ(replaceAsNobody(), "written, Operation not permitted");
    EXPECT_EQ(TextOf(path), "new");
    // The folder takes no new files either
    ASSERT_EQ(chmod(folder.Path().c_str(), 0755), 0);
    Put(path, "old text");
    EXPECT_EQ(replaceAsNobody(), "written, Permission denied");
    EXPECT_EQ(TextOf(path), "new");
    EXPECT_EQ(FileCount(folder.Path()), 1u);
}

TEST(AtomicFile, FileThatIsMountedByItselfIsWrittenInPlace) {
    const TemporaryFolder folder;
    const fs::path path = folder / "out.txt";
    Put(path, "old text");
    const std::string said = InChild([&]() -> std::string {
        if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
            mount(path.c_str(), path.c_str(), nullptr, MS_BIND, nullptr) != 0)
            return "not allowed";
        return ReplaceInChild(path);
    });
    if (said == "not allowed") GTEST_SKIP() << "mounting is not allowed here";
    EXPECT_EQ(said, "written, Device or resource busy");
    EXPECT_EQ(TextOf(path), "new");
    EXPECT_EQ(FileCount(folder.Path()), 1u);
}

TEST(AtomicFile, FileThatMayNotChangeIsRefused) {
    const TemporaryFolder folder;
    const fs::path path = folder / "out.txt";
    Put(path, "old");
    const int descriptor = open(path.c_str(), O_RDONLY);
    int flags = FS_IMMUTABLE_FL;
    const bool isFixed = ioctl(descriptor, FS_IOC_SETFLAGS, &flags) == 0;
    if (!isFixed) close(descriptor);
    if (!isFixed) GTEST_SKIP() << "a file cannot be made immutable here";
    EXPECT_EQ(IoError([&] { AtomicFile file(path); }),
              path.string() + ": cannot replace: Operation not permitted");
    flags = 0;
    EXPECT_EQ(ioctl(descriptor, FS_IOC_SETFLAGS, &flags), 0);
    close(descriptor);
    EXPECT_EQ(TextOf(path), "old");
}

// The system does not always tell beforehand that a name cannot be replaced.
TEST(AtomicFile, FileThatTurnsOutToBeIrreplaceableIsWrittenInPlace) {
    for (const int openUnnamed : {0, EOPNOTSUPP}) {
        const TemporaryFolder folder;
        const fs::path path = folder / "out.txt";
        Put(path, "old text");
        const testing::FailingFiles failing({.openUnnamed = openUnnamed, .renameat = EBUSY});
        {
            AtomicFile file(path);
            file.Write(ToBytes("new"));
            file.Commit();
        }
        EXPECT_EQ(TextOf(path), "new");
        EXPECT_EQ(FileCount(folder.Path()), 1u);
    }
}

// If /proc is hidden, links are restricted, or the file system has none, a file without a name never gets
// one. A process that has the old file open still reads all of it.
TEST(AtomicFile, FileThatCannotBeLinkedReplacesTheTargetAtOnceAllTheSame) {
    for (const int error : {EPERM, EACCES, ENOENT, EXDEV, EOPNOTSUPP}) {
        const TemporaryFolder folder;
        const fs::path path = folder / "out.txt";
        const testing::FailingFiles failing({.linkat = error});
        for (const std::string text : {"new text", "newer"}) {
            std::ifstream before(path, std::ios::binary);
            const bool isThere = before.is_open();
            AtomicFile file(path);
            file.Write(ToBytes(text));
            file.Commit();
            EXPECT_EQ(file.InPlaceReason(), "");
            EXPECT_EQ(TextOf(path), text) << error;
            EXPECT_EQ(FileCount(folder.Path()), 1u) << error;
            const std::string ofOld(std::istreambuf_iterator<char>(before), {});
            EXPECT_EQ(ofOld, isThere ? "new text" : "") << error;
            ASSERT_EQ(chmod(path.c_str(), 0640), 0);
        }
        EXPECT_EQ(fs::status(path).permissions(), fs::perms(0640)) << error;
    }
}

TEST(AtomicFile, FileThatCanBeNeitherLinkedNorRenamedIsWrittenInPlace) {
    const TemporaryFolder folder;
    Put(folder / "out.txt", "old text");
    const testing::FailingFiles failing({.linkat = EPERM, .renameat = EBUSY});
    {
        AtomicFile file(folder / "out.txt");
        file.Write(ToBytes("new"));
        file.Commit();
    }
    EXPECT_EQ(TextOf(folder / "out.txt"), "new");
    EXPECT_EQ(FileCount(folder.Path()), 1u);
}

// The disk fills up after the new content has been collected on another one. Some file systems cannot reserve
// space: there, too, the old content is not overwritten before.
TEST(AtomicFile, FullDiskLeavesTheOldContentOfAFileInPlace) {
    const std::string old(40'000, 'o'), larger(60'000, 'n');
    for (const int fallocate : {0, EOPNOTSUPP}) {
        const TemporaryFolder folder;
        const fs::path path = folder / "out.txt";
        Put(path, old);
        const testing::FailingFiles failing({.renameat = EBUSY, .fallocate = fallocate});
        {
            AtomicFile file(path);
            file.Write(ToBytes(larger));
            file.Seek(0);  // writes the buffered data
            const testing::FileSizeLimit full(50'000);
            EXPECT_EQ(IoError([&] { file.Commit(); }), path.string() + ": cannot write: File too large");
        }
        EXPECT_TRUE(TextOf(path) == old) << fallocate;
        for (const std::string& text : {larger, old, std::string("new"), std::string(), old}) {
            AtomicFile file(path);
            file.Write(ToBytes(text));
            file.Commit();
            EXPECT_TRUE(TextOf(path) == text) << fallocate << ", " << text.size();
        }
    }
}

TEST(AtomicFile, WriteInPlaceThatBreaksOffIsATornFile) {
    const TemporaryFolder folder;
    const fs::path path = folder / "out.txt";
    Put(path, std::string(40'000, 'o'));
    const testing::FailingFiles failing({.renameat = EBUSY, .fallocate = EOPNOTSUPP});
    AtomicFile file(path);
    file.Write(ToBytes(std::string(30'000, 'n')));
    file.Seek(0);  // writes the buffered data
    // The space is there, but the write fails.
    const testing::FileSizeLimit broken(20'000);
    std::string said;
    try {
        file.Commit();
    } catch (const IncompleteFile& error) {
        said = error.what();
    }
    EXPECT_EQ(said, path.string() + ": cannot write: File too large; its old content is lost");
}

TEST(AtomicFile, FailureToRenameForAnotherReasonLeavesTheOldFile) {
    const TemporaryFolder folder;
    const fs::path path = folder / "out.txt";
    Put(path, "old");
    {
        AtomicFile file(path);
        file.Write(ToBytes("new"));
        const testing::FailingFiles failing({.renameat = ENOSPC});
        EXPECT_EQ(IoError([&] { file.Commit(); }),
                  path.string() + ": cannot replace: No space left on device");
    }
    EXPECT_EQ(TextOf(path), "old");
    EXPECT_EQ(FileCount(folder.Path()), 1u);
}

TEST(AtomicFile, FileSystemWithoutNamelessFilesGetsTheSame) {
    const TemporaryFolder folder;
    const testing::FailingFiles failing({.openUnnamed = EOPNOTSUPP});
    for (const std::string text : {"new", "newer"}) {
        AtomicFile file(folder / "out.txt");
        EXPECT_EQ(FileCount(folder.Path()), text == "new" ? 1u : 2u) << "it has a name meanwhile";
        file.Write(ToBytes(text));
        file.Commit();
        EXPECT_EQ(TextOf(folder / "out.txt"), text);
        EXPECT_EQ(FileCount(folder.Path()), 1u);
    }
}

// The child is killed while it writes.
void WriteAndBeKilled(const fs::path& path) {
    EXPECT_EQ(InChild([&]() -> std::string {
                  AtomicFile file(path);
                  file.Write(ToBytes(std::string(1 << 20, 'x')));
                  std::raise(SIGKILL);
                  return "alive";
              }),
              "");
}

TEST(AtomicFile, KilledProcessLeavesNothingWhereTheNextOneWrites) {
    for (const int openUnnamed : {0, EOPNOTSUPP}) {
        const TemporaryFolder folder;
        {
            const testing::FailingFiles failing({.openUnnamed = openUnnamed});
            WriteAndBeKilled(folder / "a.txt");
            EXPECT_TRUE(openUnnamed == 0 || FileCount(folder.Path()) == 1u) << "or this shows nothing";
        }
        AtomicFile file(folder / "b.txt");
        file.Commit();
        EXPECT_EQ(FileCount(folder.Path()), 1u);
        EXPECT_FALSE(fs::exists(folder / "a.txt"));
    }
}

TEST(AtomicFile, FileThatIsBeingWrittenIsNotTakenForALeftOne) {
    const TemporaryFolder folder;
    const testing::FailingFiles failing({.openUnnamed = EOPNOTSUPP});
    AtomicFile ours(folder / "a.txt");
    EXPECT_EQ(ReplaceInChild(folder / "b.txt"), "written, ");
    ours.Write(ToBytes("ours"));
    ours.Commit();
    EXPECT_EQ(TextOf(folder / "a.txt"), "ours");
    EXPECT_EQ(FileCount(folder.Path()), 2u);
}

// Another computer's lock may be invisible here; no file takes a day to be written.
TEST(AtomicFile, FileOfAnotherComputerIsLeftForADay) {
    const TemporaryFolder folder;
    const fs::path fresh = folder / ".raygraph-00000000-0000-0000-0000-000000000000-7-0.tmp",
                   old = folder / ".raygraph-00000000-0000-0000-0000-000000000000-7-1.tmp";
    for (const fs::path& file : {fresh, old, folder / "other.tmp"}) Put(file, "part");
    fs::last_write_time(old, fs::file_time_type::clock::now() - std::chrono::hours(25));
    fs::last_write_time(folder / "other.tmp", fs::file_time_type::clock::now() - std::chrono::hours(25));
    AtomicFile file(folder / "a.txt");
    file.Commit();
    EXPECT_TRUE(fs::exists(fresh));
    EXPECT_FALSE(fs::exists(old));
    EXPECT_TRUE(fs::exists(folder / "other.tmp")) << "which is not ours";
}

}  // namespace
}  // namespace raygraph::test::atomic_file_system_test
