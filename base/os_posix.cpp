#include "base/os.h"

#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <linux/capability.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__GLIBC__) || __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <mutex>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/large_pages.h"
#include "base/text.h"

namespace raygraph::os {

// ----------------------------------------------------------------------------------------------- files

InputFile::InputFile(const std::filesystem::path& path, Links links, std::error_code& error) {
    // O_NONBLOCK has no effect on a regular file
    constexpr int kFlags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;
    m_descriptor = open(path.c_str(), links == Links::Refuse ? kFlags | O_NOFOLLOW : kFlags);
    error = m_descriptor < 0 ? LastError() : std::error_code();
}

InputFile::~InputFile() {
    if (m_descriptor >= 0) close(m_descriptor);
}

std::optional<uint64_t> InputFile::RegularSize(std::error_code& error) const {
    struct stat status = {};
    error = fstat(m_descriptor, &status) != 0 ? LastError() : std::error_code();
    if (error || !S_ISREG(status.st_mode)) return std::nullopt;
    return static_cast<uint64_t>(status.st_size);
}

size_t InputFile::Read(std::span<std::byte> bytes, std::error_code& error) {
    error.clear();
    size_t filled = 0;
    while (filled < bytes.size()) {
        const ssize_t got = read(m_descriptor, bytes.data() + filled, bytes.size() - filled);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) error = LastError();
        if (got <= 0) break;
        filled += static_cast<size_t>(got);
    }
    return filled;
}

uint64_t Position(std::FILE* stream, std::error_code& error) {
    const off_t position = ftello(stream);
    error = position < 0 ? LastError() : std::error_code();
    return position < 0 ? 0 : static_cast<uint64_t>(position);
}

void Seek(std::FILE* stream, uint64_t position, std::error_code& error) {
    const bool isDone = fseeko(stream, static_cast<off_t>(position), SEEK_SET) == 0;
    error = isDone ? std::error_code() : LastError();
}

// ------------------------------------------------------------------------------------------- new files

namespace {

constexpr std::string_view kPrefix = ".raygraph-", kSuffix = ".tmp";
constexpr time_t kSecondsUntilAbandoned = 24 * 60 * 60;
// Opening neither blocks, nor makes a terminal the process's own.
constexpr int kOpenFlags = O_CLOEXEC | O_NONBLOCK | O_NOCTTY;

// Returns an identifier that is the same for all containers of a computer, and another one after each start;
// "" where it is not known.
const std::string& BootId() {
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
    return Text("{}{}-{}-{}{}", kPrefix, BootId(), getpid(), counter++, kSuffix);
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
    const int descriptor = openat(folder, name, O_RDWR | O_NOFOLLOW | kOpenFlags);
    if (descriptor < 0) return;
    const std::string& start = BootId();
    const bool isFromThisBoot =
        !start.empty() && std::string_view(name).substr(kPrefix.size()).starts_with(start);
    struct stat opened {
    }, named{};
    const bool isAbandoned = fstat(descriptor, &opened) == 0 && S_ISREG(opened.st_mode) &&
                             (isFromThisBoot || time(nullptr) - opened.st_mtime > kSecondsUntilAbandoned) &&
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
    // Returns whether to stop waiting: at the deadline, or soon after a request to end. If `waits`, there
    // is no deadline.
    bool IsOver(bool waits) {
        const Clock::time_point now = Clock::now();
        if (!IsStopRequested()) return !waits && now >= m_start + kReaderTimeout;
        m_asked = std::min(m_asked, now);
        return now >= m_asked + kStopTimeout;
    }

  private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::seconds kReaderTimeout{30}, kStopTimeout{2};

    Clock::time_point m_start = Clock::now();
    // The time is in the far future until a request has been seen.
    Clock::time_point m_asked = m_start + std::chrono::hours(24 * 365);
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
        int to = open(target, O_WRONLY | kOpenFlags);
        if (to < 0 && errno == ENOENT) to = open(target, O_WRONLY | O_CREAT | O_EXCL | kOpenFlags, 0666);
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
    return fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS;  // a pipe has no disk
}

// Makes room for `size` bytes in a file, which keeps its `oldSize` bytes of content and, where there is no
// room, its size. Where the file system cannot reserve room, what goes beyond the old content is written and
// synced first.
bool ReserveSpace(int from, int to, off_t oldSize, off_t size) {
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

// /proc may be hidden by now, links may be restricted, or the file system may not support them.
bool NewFile::CopyToNamed(std::error_code& error) {
    const int nameless = std::exchange(m_descriptor, -1);
    struct stat status {};
    bool isDone = OpenNamed(error);
    if (isDone) {
        isDone = fstat(nameless, &status) == 0 && CopyContent(nameless, m_descriptor, 0);
        // The permissions are set as in the constructor.
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
    if (isRegular) isDone = isDone && ReserveSpace(m_descriptor, to, status.st_size, source.st_size);
    const bool isBegun = isDone;
    isDone = isDone && CopyContent(m_descriptor, to, 0);
    isDone = isDone && (!isRegular || ftruncate(to, source.st_size) == 0) && SyncToDisk(to);
    if (!isDone) error = LastError();
    if (to >= 0 && close(to) != 0 && !error) error = LastError();
    return error && isBegun && isRegular ? OldContent::Lost : OldContent::Kept;
}

std::error_code CheckReplaceable(const std::filesystem::path& file) {
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    constexpr unsigned kWanted = STATX_TYPE | STATX_MODE | STATX_UID;
    struct statx info {
    }, ofFolder{};
    if (statx(AT_FDCWD, file.c_str(), AT_SYMLINK_NOFOLLOW, kWanted, &info) != 0 ||
        statx(AT_FDCWD, folder.c_str(), 0, kWanted, &ofFolder) != 0)
        return errno == ENOENT ? std::error_code() : LastError();
    if (S_ISDIR(info.stx_mode)) return std::make_error_code(std::errc::is_a_directory);
    if ((info.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0)
        return std::make_error_code(std::errc::device_or_resource_busy);
    constexpr uint64_t kFixed = STATX_ATTR_IMMUTABLE | STATX_ATTR_APPEND;
    const bool isFixed = ((info.stx_attributes | ofFolder.stx_attributes) & kFixed) != 0;
    const uid_t user = geteuid();
    const bool isForeign =
        (ofFolder.stx_mode & S_ISVTX) != 0 && info.stx_uid != user && ofFolder.stx_uid != user;
    if (isFixed || (isForeign && !MayActAsOwner()))
        return std::make_error_code(std::errc::operation_not_permitted);
    if (faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) != 0) return LastError();
    return {};
}

std::error_code CheckOverwritable(const std::filesystem::path& file) {
    struct stat status {};
    if (stat(file.c_str(), &status) != 0) return LastError();
    // The reader of a pipe would take the end of this for the end of the content, and a device may do
    // anything.
    if (!S_ISREG(status.st_mode))
        return faccessat(AT_FDCWD, file.c_str(), W_OK, AT_EACCESS) == 0 ? std::error_code() : LastError();
    const int descriptor = open(file.c_str(), O_WRONLY | kOpenFlags);
    if (descriptor < 0) return LastError();
    close(descriptor);
    return {};
}

// ------------------------------------------------------------------------------------------- libraries

void* OpenLibrary(const char* name, std::string& whyNot) {
    void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (library != nullptr) return library;
    const char* reason = dlerror();
    whyNot = reason != nullptr ? reason : name;
    return nullptr;
}

void* FunctionOf(void* library, const char* name) {
    return dlsym(library, name);
}

// --------------------------------------------------------------------------------------- the allocator

void MapLargeBlocks() noexcept {
#ifdef M_MMAP_THRESHOLD
    // A threshold that is set explicitly no longer grows with the blocks that are freed.
    mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

// ---------------------------------------------------------------------------------------- memory pages

namespace {

constexpr size_t kSmallPageBytes = size_t{64} << 10;  // or less

size_t InPages(size_t bytes) {
    return (bytes + kSmallPageBytes - 1) / kSmallPageBytes * kSmallPageBytes;
}

}  // namespace

void* AllocateLargePages(size_t bytes) noexcept {
    const size_t used = InPages(bytes), all = used + kLargePageBytes;
    if (used < bytes || all < used) return nullptr;
    void* const memory = mmap(nullptr, all, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return nullptr;
    auto* const first = static_cast<char*>(memory);
    const size_t before =
        (kLargePageBytes - reinterpret_cast<uintptr_t>(first) % kLargePageBytes) % kLargePageBytes;
    if (before > 0) munmap(first, before);
    munmap(first + before + used, all - before - used);
#ifdef MADV_HUGEPAGE
    madvise(first + before, used, MADV_HUGEPAGE);
#endif
    return first + before;
}

void FreeLargePages(void* memory, size_t bytes) noexcept {
    munmap(memory, InPages(bytes));
}

// ----------------------------------------------------------------------- this process and its terminal

namespace {

rusage Usage() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage;
}

double Seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

double ProcessCpuSeconds() {
    const rusage usage = Usage();
    return Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
}

uint64_t PeakResidentBytes() {
    return uint64_t{1024} * static_cast<uint64_t>(Usage().ru_maxrss);  // Linux counts in KiB
}

void IgnoreWriteSignals() noexcept {
    for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
    // The lowest free number is the next one that is opened
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (fcntl(stream, F_GETFD) < 0)
            (void)!open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

bool IsTerminal(std::FILE* stream) {
    return isatty(fileno(stream)) == 1;
}

size_t TerminalWidth(std::FILE* stream) {
    winsize size{};
    const bool isKnown = ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    return isKnown ? size.ws_col : 80;
}

std::string LocalTimeOfDay() {
    const time_t now = time(nullptr);
    tm local{};
    localtime_r(&now, &local);
    char text[16];
    return std::string(text, strftime(text, sizeof(text), "%H:%M:%S", &local));
}

bool MatchesPattern(const std::string& text, const std::string& pattern) {
    return fnmatch(pattern.c_str(), text.c_str(), 0) == 0;
}

// -------------------------------------------------------------------------------------- other programs

bool FindProgram(const std::string& name) {
    const char* variable = std::getenv("PATH");
    std::string_view folders = variable ? variable : "";
    while (!folders.empty()) {
        const size_t end = std::min(folders.find(':'), folders.size());
        const std::filesystem::path file = std::filesystem::path(folders.substr(0, end)) / name;
        if (access(file.c_str(), X_OK) == 0) return true;
        folders.remove_prefix(std::min(end + 1, folders.size()));
    }
    return false;
}

std::filesystem::path ProgramFile() {
    std::error_code error;
    std::filesystem::path file = std::filesystem::read_symlink("/proc/self/exe", error);
    return error ? std::filesystem::path() : file;
}

std::string ForShell(const std::string& word) {
    constexpr std::string_view kPlain = "-_./,:=+%@";
    const auto isPlain = [&](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               kPlain.find(c) != std::string_view::npos;
    };
    if (!word.empty() && std::ranges::all_of(word, isPlain)) return word;
    const bool isInert = word.find_first_of("\"\\$`!") == std::string::npos;
    if (isInert) return '"' + word + '"';
    std::string quoted = "'";
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

namespace {

// Becomes the program; for a child that has the memory of its parent until then. Does not return.
[[noreturn]] void Execute(char* const* arguments, int output, ErrorStream errors, pid_t parent,
                          const sigset_t& signals, volatile bool& isStarted) {
    // A handler of the parent would run in its memory
    for (int signal = 1; signal < NSIG; ++signal) {
        struct sigaction action {};
        if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
        action = {};
        action.sa_handler = SIG_DFL;
        sigaction(signal, &action, nullptr);
    }
    // dup2 of a descriptor onto itself, where the parent has no output, leaves it to be closed
    if (output == STDOUT_FILENO || output == STDERR_FILENO) fcntl(output, F_SETFD, 0);
    // A parent that is killed cannot end it; one that was killed before this call is not its parent any more
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    const bool isReady = getppid() == parent && dup2(output, STDOUT_FILENO) >= 0 &&
                         (errors == ErrorStream::Inherited || dup2(output, STDERR_FILENO) >= 0) &&
                         sigprocmask(SIG_SETMASK, &signals, nullptr) == 0;
    if (isReady) execvp(arguments[0], arguments);
    isStarted = false;
    _exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command, ErrorStream errors) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return;
    std::vector<char*> arguments;
    for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const pid_t parent = getpid();
    volatile bool isStarted = true;
    // This thread waits until the child is the program: the pages of a large scene need not be copied
    const pid_t process = vfork();
    if (process == 0) Execute(arguments.data(), ends[1], errors, parent, before, isStarted);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    close(ends[1]);
    m_pipe = ends[0];
    fcntl(m_pipe, F_SETFL, O_NONBLOCK);
    if (process < 0) return;
    m_process = process;
    m_isStarted = isStarted;
    if (m_isStarted) return;
    Reap();
    m_status.reset();
}

ChildProcess::~ChildProcess() {
    if (m_process != 0) {
        Terminate();
        Reap();
    }
    if (m_pipe >= 0) close(m_pipe);
}

void ChildProcess::Terminate() {
    if (m_process != 0) kill(m_process, SIGTERM);
}

void ChildProcess::Kill() {
    if (m_process == 0) return;
    kill(m_process, SIGKILL);
    Reap();
}

void ChildProcess::Reap() {
    int status = 0;
    while (waitpid(m_process, &status, 0) < 0 && errno == EINTR) {
    }
    m_process = 0;
    if (WIFEXITED(status)) m_status = WEXITSTATUS(status);
}

bool ChildProcess::IsRunning() {
    if (m_process == 0) return false;
    std::array<char, 4096> bytes;
    ssize_t count = 0;
    while ((count = read(m_pipe, bytes.data(), bytes.size())) > 0)
        m_written.append(bytes.data(), static_cast<size_t>(count));
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return true;
    Reap();  // it has closed its stdout, which is its end
    return false;
}

// --------------------------------------------------------------------------------------------- signals

namespace {

// They are lock-free, so allowed in a signal handler; Mesa's worker threads may be the ones that run it.
std::atomic<bool> isInterrupted{false}, isTerminated{false}, isSaveRequested{false}, isDeferring{false};
std::atomic<void (*)()> terminationHandler{nullptr};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<void (*)()>::is_always_lock_free);

constexpr std::array kTerminationSignals{SIGTERM, SIGUSR2, SIGHUP, SIGXCPU};

void HandleInterrupt(int) {
    isInterrupted.store(true, std::memory_order_relaxed);
}

void HandleTermination(int) {
    if (!isDeferring.load(std::memory_order_relaxed)) terminationHandler.load(std::memory_order_relaxed)();
    isTerminated.store(true, std::memory_order_relaxed);
}

void HandleSaveRequest(int) {
    isSaveRequested.store(true, std::memory_order_relaxed);
}

}  // namespace

struct SignalWatch::Before {
    // `flags` are added to SA_RESTART.
    void Handle(int signal, void (*handler)(int), int flags = 0) {
        struct sigaction before {
        }, action{};
        sigaction(signal, nullptr, &before);
        if (before.sa_handler == SIG_IGN) return;
        action.sa_handler = handler;
        action.sa_flags = flags | SA_RESTART;
        sigemptyset(&action.sa_mask);
        sigaction(signal, &action, nullptr);
        handled.emplace_back(signal, before);
    }

    std::vector<std::pair<int, struct sigaction>> handled;
    bool isDeferringInterrupts = false;
};

SignalWatch::SignalWatch(void (*onTermination)()) : m_before(std::make_unique<Before>()) {
    isInterrupted = isTerminated = isSaveRequested = isDeferring = false;
    terminationHandler = onTermination;
    for (const int signal : kTerminationSignals) m_before->Handle(signal, HandleTermination);
    m_before->Handle(SIGUSR1, HandleSaveRequest);
}

void SignalWatch::StartDeferring() {
    isDeferring = true;
    if (std::exchange(m_before->isDeferringInterrupts, true)) return;
    m_before->Handle(SIGINT, HandleInterrupt, static_cast<int>(SA_RESETHAND));
}

SignalWatch::~SignalWatch() {
    for (const auto& [signal, before] : m_before->handled) sigaction(signal, &before, nullptr);
    isInterrupted = isTerminated = false;
}

bool SignalWatch::IsInterrupted() const {
    return isInterrupted.load(std::memory_order_relaxed);
}

bool SignalWatch::IsTerminated() const {
    return isTerminated.load(std::memory_order_relaxed);
}

bool SignalWatch::IsSaveRequested() const {
    return isSaveRequested.load(std::memory_order_relaxed);
}

void SignalWatch::ClearSaveRequest() {
    isSaveRequested.store(false, std::memory_order_relaxed);
}

bool IsStopRequested() {
    return isInterrupted.load(std::memory_order_relaxed) || isTerminated.load(std::memory_order_relaxed);
}

}  // namespace raygraph::os
