#include "base/os/new_file.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <ctime>
#include <mutex>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "base/os/file.h"
#include "base/text.h"

namespace raygraph::os {

namespace {

constexpr std::string_view kPrefix = ".raygraph-", kSuffix = ".tmp";
constexpr time_t kSecondsUntilAbandoned = 24 * 60 * 60;
// Opening neither blocks, nor makes a terminal the process's own.
constexpr int kQuietly = O_CLOEXEC | O_NONBLOCK | O_NOCTTY;

std::error_code LastError() {
    return {errno, std::generic_category()};
}

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

// Once in a process for each path: listing a folder of many frames takes long.
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

// All of the content, from the start of both.
bool CopyContent(int from, int to) {
    std::array<char, 1 << 16> buffer;
    for (off_t at = 0;;) {
        ssize_t count = pread(from, buffer.data(), buffer.size(), at);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return count == 0;
        at += count;
        for (const char* rest = buffer.data(); count > 0;) {
            const ssize_t written = write(to, rest, static_cast<size_t>(count));
            if (written < 0 && errno == EINTR) continue;
            if (written < 0) return false;
            rest += written;
            count -= written;
        }
    }
}

bool SyncToDisk(int descriptor) {
    return fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS;  // such as a pipe
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
    // Permissions that cannot be set are no reason to lose a render: those of the umask stay
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
        // Until it was locked it looked abandoned, so that another process may be about to remove it, or may
        // have done so. A file system without locks has no such processes.
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

bool NewFile::Link(const std::string& name) const {
    return linkat(AT_FDCWD, PathOf(m_descriptor).c_str(), m_folder, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
}

void NewFile::Publish(const std::filesystem::path& name, std::error_code& error) {
    error.clear();
    if (m_name.empty()) {
        if (Link(name)) return;
        // A link replaces nothing. The file has its name for the time of one rename.
        while (errno == EEXIST && m_name.empty())
            if (std::string own = TemporaryName(); Link(own)) m_name = std::move(own);
    }
    if (m_name.empty() || renameat(m_folder, m_name.c_str(), m_folder, name.c_str()) != 0)
        error = LastError();
    else
        m_name.clear();
}

void NewFile::CopyTo(const std::filesystem::path& target, std::error_code& error) const {
    error.clear();
    // A file of another user in a shared folder may be opened, but not by a call that might create it
    int to = open(target.c_str(), O_WRONLY | kQuietly);
    if (to < 0 && errno == ENOENT) to = open(target.c_str(), O_WRONLY | O_CREAT | O_EXCL | kQuietly, 0666);
    struct stat source {
    }, status{};
    bool isDone = to >= 0 && fstat(m_descriptor, &source) == 0 && fstat(to, &status) == 0;
    // From here on, a pipe may wait for its reader
    isDone = isDone && fcntl(to, F_SETFL, fcntl(to, F_GETFL) & ~O_NONBLOCK) == 0;
    isDone = isDone && CopyContent(m_descriptor, to);
    isDone = isDone && (!S_ISREG(status.st_mode) || ftruncate(to, source.st_size) == 0) && SyncToDisk(to);
    if (!isDone) error = LastError();
    if (to >= 0 && close(to) != 0 && !error) error = LastError();
}

std::error_code RefusalToReplace(const std::filesystem::path& file) {
    struct statx status {};
    if (statx(AT_FDCWD, file.c_str(), AT_SYMLINK_NOFOLLOW, 0, &status) == 0 &&
        (status.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0)
        return std::make_error_code(std::errc::device_or_resource_busy);
    // Whether the file may be removed is asked before it is found to be no folder, so nothing is ever removed
    if (rmdir(file.c_str()) == 0 || errno == ENOTDIR || errno == ENOENT) return {};
    return LastError();
}

std::error_code RefusalToWrite(const std::filesystem::path& file) {
    struct stat status {};
    if (stat(file.c_str(), &status) != 0) return LastError();
    // The reader of a pipe would take the end of this for the end of the content, and a device may do
    // anything
    if (!S_ISREG(status.st_mode))
        return faccessat(AT_FDCWD, file.c_str(), W_OK, AT_EACCESS) == 0 ? std::error_code() : LastError();
    const int descriptor = open(file.c_str(), O_WRONLY | kQuietly);
    if (descriptor < 0) return LastError();
    close(descriptor);
    return {};
}

}  // namespace raygraph::os
