#include "base/atomic_file.h"

#include <cerrno>
#include <optional>

#include "base/check.h"
#include "base/os/file.h"
#include "base/text.h"

namespace raygraph {
namespace {

constexpr int kMaxLinkCount = 40;  // As Linux has it.

// What stdio's functions leave behind.
std::error_code LastError() {
    return {errno != 0 ? errno : EIO, std::generic_category()};
}

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& target) : m_target(target) {
    // Link by link, so that a link to a file that does not exist yet is followed too.
    std::error_code error;
    for (int linkCount = 0; std::filesystem::is_symlink(m_target, error); ++linkCount) {
        if (linkCount == kMaxLinkCount)
            Fail("cannot follow the link", std::make_error_code(std::errc::too_many_symbolic_link_levels));
        const std::filesystem::path next = std::filesystem::read_symlink(m_target, error);
        if (error) Fail("cannot follow the link", error);
        m_target = m_target.parent_path() / next;
    }
    std::optional<std::filesystem::perms> permissions;
    const std::filesystem::file_status existing = std::filesystem::status(m_target, error);
    if (std::filesystem::exists(existing)) {
        if (!std::filesystem::is_regular_file(existing))
            throw MakeError(ErrorKind::Io, "{}: cannot write: it is not a regular file", m_target.string());
        permissions = existing.permissions();
    }
    do {
        m_temporary = os::TemporaryName(m_target.parent_path());
        m_stream = os::CreateNew(m_temporary, permissions, error);
    } while (error == std::errc::file_exists);
    if (error) Fail("cannot create a file in its folder", error);
}

AtomicFile::~AtomicFile() {
    if (m_stream != nullptr) std::fclose(m_stream);
    std::error_code ignored;
    if (!m_temporary.empty()) std::filesystem::remove(m_temporary, ignored);
}

void AtomicFile::Fail(const char* what, const std::error_code& error) const {
    throw MakeError(ErrorKind::Io, "{}: {}: {}", m_target.string(), what, error.message());
}

void AtomicFile::Write(std::span<const std::byte> bytes) {
    RG_CHECK(m_stream != nullptr);
    errno = 0;
    if (std::fwrite(bytes.data(), 1, bytes.size(), m_stream) != bytes.size()) {
        m_isWriteFailed = true;
        Fail("cannot write", LastError());
    }
}

uint64_t AtomicFile::Position() const {
    RG_CHECK(m_stream != nullptr);
    std::error_code error;
    const uint64_t position = os::Position(m_stream, error);
    if (error) Fail("cannot tell the position", error);
    return position;
}

void AtomicFile::Seek(uint64_t position) {
    RG_CHECK(m_stream != nullptr);
    // Seeking writes out what is buffered, so it fails as a write does.
    std::error_code error;
    os::Seek(m_stream, position, error);
    if (!error) return;
    m_isWriteFailed = true;
    Fail("cannot write", error);
}

void AtomicFile::Commit() {
    RG_CHECK(m_stream != nullptr);
    errno = 0;
    const bool isFailed = m_isWriteFailed || std::ferror(m_stream) != 0 || std::fflush(m_stream) != 0;
    if (isFailed) Fail("cannot write", LastError());
    std::error_code error;
    os::Sync(m_stream, error);
    if (error) Fail("cannot write", error);
    const int closed = std::fclose(m_stream);
    m_stream = nullptr;
    if (closed != 0) Fail("cannot write", LastError());
    std::filesystem::rename(m_temporary, m_target, error);
    if (error) Fail("cannot replace", error);
    m_temporary.clear();
}

}  // namespace raygraph
