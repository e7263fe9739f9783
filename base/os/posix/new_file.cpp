#include "base/os/new_file.h"

#include <dirent.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <mutex>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "base/os/file.h"
#include "base/os/last_error.h"
#include "base/os/signals.h"
#include "base/text.h"

namespace raygraph::os {

namespace {

constexpr std::string_view kPrefix = ".raygraph-", kSuffix = ".tmp";
constexpr time_t kSecondsUntilAbandoned = 24 * 60 * 60;
// Opening neither blocks, nor makes a terminal the process's own.
constexpr int kQuietly = O_CLOEXEC | O_NONBLOCK | O_NOCTTY;

// It is the same for all containers of a computer, and another one after each start; "" where it is not
// known.
const std::string& StartOfThisComputer() {
    static const std::string id = [] {
        std::array<char, 36> text{};
        std::error_code error;
        InputFile file("/proc/sys/kernel/random/boot_id", Links::Follow, error);
        const bool isRead =
            !error && file.Read(std::as_writable_bytes(std::span(text)), error) == text.size() && !error;
        return isRead ? std::string(text.data(), text.size()) : std::string();
    }();
    return id;
}

std::string TemporaryName() {
    static std::atomic<uint32_t> counter{0};
    return Text("{}{}-{}-{}{}", kPrefix, StartOfThisComputer(), getpid(), counter++, kSuffix);
}

// Without the privilege for AT_EMPTY_PATH, a file without a name can be linked by this path alone.
std::string PathOf(int descriptor) {
    return Text("/proc/self/fd/{}", descriptor);
}

bool IsSameFile(const struct stat& a, const struct stat& b) {
    return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

// Takes the lock that a living writer holds. The name is looked at once more, because another process may
// have removed the file in between; nobody does so while the lock is held.
void RemoveIfAbandoned(int folder, const char* name) {
    const int descriptor = openat(folder, name, O_RDWR | O_NOFOLLOW | kQuietly);
    if (descriptor < 0) return;
    const std::string& start = StartOfThisComputer();
    const bool isOfThisComputer =
        !start.empty() && std::string_view(name).substr(kPrefix.size()).starts_with(start);
    struct stat opened {
    }, named{};
    const bool isAbandoned = fstat(descriptor, &opened) == 0 && S_ISREG(opened.st_mode) &&
                             (isOfThisComputer || time(nullptr) - opened.st_mtime > kSecondsUntilAbandoned) &&
                             flock(descriptor, LOCK_EX | LOCK_NB) == 0 &&
                             fstatat(folder, name, &named, AT_SYMLINK_NOFOLLOW) == 0 &&
                             IsSameFile(opened, named);
    if (isAbandoned) unlinkat(folder, name, 0);
    close(descriptor);
}

// Does its work once in a process for each path, because listing a folder of many frames takes long.
void RemoveAbandoned(int folder, const std::string& path) {
    static std::mutex mutex;
    static std::set<std::string> done;
    {
        const std::scoped_lock lock(mutex);
        if (!done.insert(path).second) return;
    }
    const int descriptor = openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR* const list = descriptor < 0 ? nullptr : fdopendir(descriptor);
    if (list == nullptr) {
        if (descriptor >= 0) close(descriptor);
        return;
    }
    while (const dirent* entry = readdir(list)) {
        const std::string_view name = entry->d_name;
        if (name.starts_with(kPrefix) && name.ends_with(kSuffix)) RemoveIfAbandoned(folder, entry->d_name);
    }
    closedir(list);
}

// The reader of a pipe is waited for, but not forever: nobody may be there to end the wait. Between being
// asked to end and being killed, a process has little time.
class Patience {
  public:
    // Returns whether to stop waiting: at the deadline, or soon after a request to end. If `isPatient`, there
    // is no deadline.
    bool IsOver(bool isPatient) {
        const Clock::time_point now = Clock::now();
        if (!IsAskedToEnd()) return !isPatient && now >= m_start + kForAReader;
        m_asked = std::min(m_asked, now);
        return now >= m_asked + kAtTheEnd;
    }

  private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::seconds kForAReader{30}, kAtTheEnd{2};

    Clock::time_point m_start = Clock::now();
    Clock::time_point m_asked = m_start + std::chrono::hours(24 * 365);  // It was not seen to be asked yet.
};

bool IsPipe(const char* path) {
    struct stat status {};
    return stat(path, &status) == 0 && S_ISFIFO(status.st_mode);
}

// Opens a file, a device or a pipe for CopyTo. Returns -1 and leaves errno if it cannot be opened: ETIMEDOUT
// for a pipe without a reader. A blocking call would wait for the reader through all signals but those that
// kill.
int OpenTarget(const char* target) {
    for (Patience patience;; poll(nullptr, 0, 20)) {
        // A file of another user in a shared folder may be opened, but not by a call that might create it.
        int to = open(target, O_WRONLY | kQuietly);
        if (to < 0 && errno == ENOENT) to = open(target, O_WRONLY | O_CREAT | O_EXCL | kQuietly, 0666);
        if (to >= 0 || errno != ENXIO) return to;
        if (!IsPipe(target)) {
            errno = ENXIO;
            return -1;
        }
        if (patience.IsOver(false)) {
            errno = ETIMEDOUT;
            return -1;
        }
    }
}

// Waits until the reader of a pipe makes room. A reader that has come may take its time.
bool WaitForRoom(int pipe, Patience& patience) {
    pollfd room{.fd = pipe, .events = POLLOUT, .revents = 0};
    poll(&room, 1, 100);
    if (!patience.IsOver(true)) return true;
    errno = ETIMEDOUT;
    return false;
}

// Copies the content from position `at` on to the same position.
bool CopyContent(int from, int to, off_t at) {
    std::array<char, 1 << 16> buffer;
    Patience patience;
    (void)lseek(to, at, SEEK_SET);  // A pipe has no positions, and is at its start.
    for (;;) {
        ssize_t count = pread(from, buffer.data(), buffer.size(), at);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return count == 0;
        at += count;
        for (const char* rest = buffer.data(); count > 0;) {
            const ssize_t written = write(to, rest, static_cast<size_t>(count));
            if (written < 0 && errno == EINTR) continue;
            if (written < 0 && errno == EAGAIN && WaitForRoom(to, patience)) continue;
            if (written < 0) return false;
            patience = {};
            rest += written;
            count -= written;
        }
    }
}

bool SyncToDisk(int descriptor) {
    return fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS;  // A pipe has no disk.
}

// Makes room for `size` bytes in a file, which keeps its `oldSize` bytes of content and, where there is no
// room, its size. Where the file system cannot reserve room, what goes beyond the old content is written and
// synced first.
bool MakeRoom(int from, int to, off_t oldSize, off_t size) {
    int result = 0;
    do result = size == 0 ? 0 : fallocate(to, 0, 0, size);
    while (result != 0 && errno == EINTR);
    if (result == 0) return true;
    const bool canReserve = errno != EOPNOTSUPP && errno != ENOSYS;
    if (!canReserve && (size <= oldSize || (CopyContent(from, to, oldSize) && SyncToDisk(to)))) return true;
    const int reason = errno;
    (void)!ftruncate(to, oldSize);
    errno = reason;
    return false;
}

// Returns whether this process may do with files of others what their owners may.
bool MayActAsOwner() {
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> sets{};
    return syscall(SYS_capget, &header, sets.data()) == 0 &&
           (sets[CAP_TO_INDEX(CAP_FOWNER)].effective & CAP_TO_MASK(CAP_FOWNER)) != 0;
}

}  // namespace

NewFile::NewFile(const std::filesystem::path& folder, std::optional<std::filesystem::perms> permissions,
                 std::error_code& error) {
    error.clear();
    m_folder = open(folder.empty() ? "." : folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (m_folder < 0) {
        error = LastError();
        return;
    }
    m_descriptor = openat(m_folder, ".", O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
    const bool isNameless = m_descriptor >= 0 && access(PathOf(m_descriptor).c_str(), F_OK) == 0 &&
                            flock(m_descriptor, LOCK_EX | LOCK_NB) == 0;
    if (!isNameless && !OpenNamed(error)) return;
    // Permissions that cannot be set are no reason to lose a render: those of the umask stay.
    if (permissions) (void)!fchmod(m_descriptor, static_cast<mode_t>(*permissions));
    const int ofStream = fcntl(m_descriptor, F_DUPFD_CLOEXEC, 0);
    m_stream = ofStream < 0 ? nullptr : fdopen(ofStream, "w+b");
    if (m_stream == nullptr) error = LastError();
    if (m_stream == nullptr && ofStream >= 0) close(ofStream);
    RemoveAbandoned(m_folder, folder);
}

NewFile::~NewFile() {
    if (m_stream != nullptr) std::fclose(m_stream);
    if (!m_name.empty()) unlinkat(m_folder, m_name.c_str(), 0);
    for (const int descriptor : {m_descriptor, m_folder})
        if (descriptor >= 0) close(descriptor);
}

bool NewFile::OpenNamed(std::error_code& error) {
    for (;;) {
        if (m_descriptor >= 0) close(m_descriptor);
        std::string name = TemporaryName();
        m_descriptor = openat(m_folder, name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (m_descriptor < 0 && (errno == EEXIST || errno == EINTR)) continue;
        if (m_descriptor < 0) {
            error = LastError();
            return false;
        }
        // Until it was locked, the file looked abandoned, so that another process may be about to remove it,
        // or may have done so. A file system without locks has no such processes.
        const bool isLocked = flock(m_descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
        if (isLocked && faccessat(m_folder, name.c_str(), F_OK, 0) == 0) {
            m_name = std::move(name);
            return true;
        }
    }
}

void NewFile::Close(std::error_code& error) {
    errno = 0;
    const bool isWritten = std::fflush(m_stream) == 0 && SyncToDisk(fileno(m_stream));
    error = isWritten ? std::error_code() : LastError();
    const bool isClosed = std::fclose(std::exchange(m_stream, nullptr)) == 0;
    if (!isClosed && !error) error = LastError();
}

std::error_code NewFile::Link(const std::string& name) const {
    const bool isDone =
        linkat(AT_FDCWD, PathOf(m_descriptor).c_str(), m_folder, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
    return isDone ? std::error_code() : LastError();
}

// /proc may be out of sight by now, links may be restricted, or the file system may know none.
bool NewFile::CopyToNamed(std::error_code& error) {
    const int nameless = std::exchange(m_descriptor, -1);
    struct stat status {};
    bool isDone = OpenNamed(error);
    if (isDone) {
        isDone = fstat(nameless, &status) == 0 && CopyContent(nameless, m_descriptor, 0);
        // They are set as in the constructor.
        if (isDone) (void)!fchmod(m_descriptor, status.st_mode & 07777);
        isDone = isDone && SyncToDisk(m_descriptor);
        error = isDone ? std::error_code() : LastError();
    }
    if (!isDone && !m_name.empty()) unlinkat(m_folder, std::exchange(m_name, {}).c_str(), 0);
    const int done = isDone ? nameless : std::exchange(m_descriptor, nameless);
    if (done >= 0) close(done);
    return isDone;
}

void NewFile::Publish(const std::filesystem::path& name, std::error_code& error) {
    error.clear();
    if (m_name.empty()) {
        error = Link(name);
        if (!error) return;
        // A link replaces nothing. The file has its name for the time of one rename.
        while (error == std::errc::file_exists) {
            std::string own = TemporaryName();
            error = Link(own);
            if (!error) m_name = std::move(own);
        }
        if (error && !CopyToNamed(error)) return;
    }
    if (renameat(m_folder, m_name.c_str(), m_folder, name.c_str()) != 0)
        error = LastError();
    else
        m_name.clear();
}

OldContent NewFile::CopyTo(const std::filesystem::path& target, std::error_code& error) const {
    error.clear();
    const int to = OpenTarget(target.c_str());
    struct stat source {
    }, status{};
    bool isDone = to >= 0 && fstat(m_descriptor, &source) == 0 && fstat(to, &status) == 0;
    const bool isRegular = S_ISREG(status.st_mode);
    if (isRegular) isDone = isDone && MakeRoom(m_descriptor, to, status.st_size, source.st_size);
    const bool isBegun = isDone;
    isDone = isDone && CopyContent(m_descriptor, to, 0);
    isDone = isDone && (!isRegular || ftruncate(to, source.st_size) == 0) && SyncToDisk(to);
    if (!isDone) error = LastError();
    if (to >= 0 && close(to) != 0 && !error) error = LastError();
    return error && isBegun && isRegular ? OldContent::Lost : OldContent::Kept;
}

std::error_code RefusalToReplace(const std::filesystem::path& file) {
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    constexpr unsigned kWanted = STATX_TYPE | STATX_MODE | STATX_UID;
    struct statx its {
    }, ofFolder{};
    if (statx(AT_FDCWD, file.c_str(), AT_SYMLINK_NOFOLLOW, kWanted, &its) != 0 ||
        statx(AT_FDCWD, folder.c_str(), 0, kWanted, &ofFolder) != 0)
        return errno == ENOENT ? std::error_code() : LastError();
    if (S_ISDIR(its.stx_mode)) return std::make_error_code(std::errc::is_a_directory);
    if ((its.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0)
        return std::make_error_code(std::errc::device_or_resource_busy);
    constexpr uint64_t kFixed = STATX_ATTR_IMMUTABLE | STATX_ATTR_APPEND;
    const bool isFixed = ((its.stx_attributes | ofFolder.stx_attributes) & kFixed) != 0;
    const uid_t user = geteuid();
    const bool isOfOthers =
        (ofFolder.stx_mode & S_ISVTX) != 0 && its.stx_uid != user && ofFolder.stx_uid != user;
    if (isFixed || (isOfOthers && !MayActAsOwner()))
        return std::make_error_code(std::errc::operation_not_permitted);
    if (faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) != 0) return LastError();
    return {};
}

std::error_code RefusalToWrite(const std::filesystem::path& file) {
    struct stat status {};
    if (stat(file.c_str(), &status) != 0) return LastError();
    // The reader of a pipe would take the end of this for the end of the content, and a device may do
    // anything.
    if (!S_ISREG(status.st_mode))
        return faccessat(AT_FDCWD, file.c_str(), W_OK, AT_EACCESS) == 0 ? std::error_code() : LastError();
    const int descriptor = open(file.c_str(), O_WRONLY | kQuietly);
    if (descriptor < 0) return LastError();
    close(descriptor);
    return {};
}

}  // namespace raygraph::os
