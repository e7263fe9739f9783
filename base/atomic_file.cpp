#include "base/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <system_error>

#include "base/check.h"
#include "base/error.h"

namespace raygraph {
namespace {

constexpr int kMaxLinkCount = 40;  // As Linux has it.

// Unique among the threads of this process by the counter and among processes by the id; O_EXCL settles the
// rest.
std::filesystem::path UniqueName(const std::filesystem::path& folder) {
    static std::atomic<uint32_t> counter{0};
    const std::string name =
        ".raygraph-" + std::to_string(getpid()) + '-' + std::to_string(counter++) + ".tmp";
    return folder / name;
}

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& target) : m_target(target) {
    // Link by link, so that a link to a file that does not exist yet is followed too.
    std::error_code error;
    for (int linkCount = 0; std::filesystem::is_symlink(m_target, error); ++linkCount) {
        if (linkCount == kMaxLinkCount) Fail("cannot follow the link", ELOOP);
        const std::filesystem::path next = std::filesystem::read_symlink(m_target, error);
        if (error) Fail("cannot follow the link", error.value());
        m_target = m_target.parent_path() / next;
    }
    mode_t existingMode = 0;
    struct stat existing = {};
    if (stat(m_target.c_str(), &existing) == 0) {
        if (!S_ISREG(existing.st_mode))
            throw Error(ErrorKind::Io, m_target.string() + ": cannot write: it is not a regular file");
        existingMode = existing.st_mode & 07777;
    }
    int descriptor = -1;
    do {
        m_temporary = UniqueName(m_target.parent_path());
        descriptor = open(m_temporary.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor < 0 && (errno == EEXIST || errno == EINTR));
    if (descriptor < 0) Fail("cannot create a file in its folder", errno);
    // A mode that cannot be kept is no reason to lose a render: the umask's stays.
    if (existingMode != 0) (void)!fchmod(descriptor, existingMode);
    m_stream = fdopen(descriptor, "w+b");
    if (m_stream == nullptr) {
        const int systemError = errno;
        close(descriptor);
        unlink(m_temporary.c_str());
        Fail("cannot open a stream", systemError);
    }
}

AtomicFile::~AtomicFile() {
    if (m_stream != nullptr) std::fclose(m_stream);
    if (!m_temporary.empty()) unlink(m_temporary.c_str());
}

void AtomicFile::Fail(const char* what, int systemError) const {
    const std::string reason = std::generic_category().message(systemError);
    throw Error(ErrorKind::Io, m_target.string() + ": " + what + ": " + reason);
}

void AtomicFile::Write(std::span<const std::byte> bytes) {
    RG_CHECK(m_stream != nullptr);
    errno = 0;
    if (std::fwrite(bytes.data(), 1, bytes.size(), m_stream) != bytes.size()) {
        m_isWriteFailed = true;
        Fail("cannot write", errno);
    }
}

uint64_t AtomicFile::Position() const {
    RG_CHECK(m_stream != nullptr);
    const off_t position = ftello(m_stream);
    if (position < 0) Fail("cannot tell the position", errno);
    return static_cast<uint64_t>(position);
}

void AtomicFile::Seek(uint64_t position) {
    RG_CHECK(m_stream != nullptr);
    // Seeking writes out what is buffered, so it fails as a write does.
    if (fseeko(m_stream, static_cast<off_t>(position), SEEK_SET) != 0) {
        m_isWriteFailed = true;
        Fail("cannot write", errno);
    }
}

void AtomicFile::Commit() {
    RG_CHECK(m_stream != nullptr);
    errno = 0;
    const bool isFailed = m_isWriteFailed || std::ferror(m_stream) != 0 || std::fflush(m_stream) != 0;
    if (isFailed) Fail("cannot write", errno != 0 ? errno : EIO);
    // Some file systems know no fsync: not a failure.
    if (fsync(fileno(m_stream)) != 0 && errno != EINVAL && errno != EROFS) Fail("cannot write", errno);
    const int closed = std::fclose(m_stream);
    m_stream = nullptr;
    if (closed != 0) Fail("cannot write", errno);
    if (std::rename(m_temporary.c_str(), m_target.c_str()) != 0) Fail("cannot replace", errno);
    m_temporary.clear();
}

}  // namespace raygraph
