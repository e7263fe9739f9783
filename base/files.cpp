#include "base/files.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <new>
#include <optional>
#include <system_error>

#include "base/check.h"
#include "base/os.h"
#include "base/text.h"

namespace raygraph {
namespace {

constexpr int kMaxLinkCount = 40;  // Linux follows as many

// Returns whether the name cannot be given to a new file, which says nothing about writing to the old one.
bool IsNameError(const std::error_code& error) {
    constexpr std::array kNameErrors{std::errc::permission_denied, std::errc::operation_not_permitted,
                                     std::errc::read_only_file_system, std::errc::device_or_resource_busy,
                                     std::errc::cross_device_link};
    return std::ranges::any_of(kNameErrors, [&](std::errc each) { return error == each; });
}

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& target) : m_given(target), m_target(target) {
    std::error_code error;
    // A stream is recognized before links are followed: the link of an open pipe, such as /dev/stdout, leads
    // to no path.
    m_isInPlace = IsStream(m_target);
    if (!m_isInPlace) {
        FollowLinks();
        OpenReplacement();
    } else if (const std::error_code refusal = os::CheckOverwritable(m_target)) {
        Fail("cannot write", refusal);
    }
    if (m_file) return;
    const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
    if (!error) m_file = std::make_unique<os::NewFile>(folder, std::nullopt, error);
    if (error) Fail("cannot collect its content in a temporary file", error);
}

AtomicFile::~AtomicFile() = default;

bool AtomicFile::IsStream(const std::filesystem::path& target) {
    std::error_code none;  // A target that cannot be looked at is no stream.
    const std::filesystem::file_status existing = std::filesystem::status(target, none);
    return std::filesystem::is_character_file(existing) || std::filesystem::is_fifo(existing);
}

// Follows link by link, so that a link to a file that does not exist yet is followed too.
void AtomicFile::FollowLinks() {
    std::error_code error;
    for (int linkCount = 0; std::filesystem::is_symlink(m_target, error); ++linkCount) {
        if (linkCount == kMaxLinkCount)
            Fail("cannot follow the link", std::make_error_code(std::errc::too_many_symbolic_link_levels));
        const std::filesystem::path next = std::filesystem::read_symlink(m_target, error);
        if (error) Fail("cannot follow the link", error);
        m_target = m_target.parent_path() / next;
    }
}

// Leaves m_file null where the folder takes no new file, and the old one is to be written in place.
void AtomicFile::OpenReplacement() {
    std::error_code error;
    const std::filesystem::file_status existing = std::filesystem::status(m_target, error);
    const bool exists = std::filesystem::exists(existing);
    if (std::filesystem::is_directory(existing))
        throw MakeError(ErrorKind::Io, "{}: cannot write: it is a folder", Name());
    if (exists && !std::filesystem::is_regular_file(existing))
        throw MakeError(ErrorKind::Io, "{}: cannot write: it is not a regular file", Name());
    // The reason may be a name that is too long.
    if (!exists && existing.type() != std::filesystem::file_type::not_found) Fail("cannot write", error);
    const auto permissions = exists ? std::optional(existing.permissions()) : std::nullopt;
    auto file = std::make_unique<os::NewFile>(m_target.parent_path(), permissions, error);
    const char* const what = error ? "cannot create a file in its folder" : "cannot replace";
    const std::error_code refusal = error || !exists ? error : os::CheckReplaceable(m_target);
    if (!error) m_file = std::move(file);
    if (!refusal) return;
    if (!exists || !IsNameError(refusal) || os::CheckOverwritable(m_target)) Fail(what, refusal);
    m_isInPlace = true;
    m_inPlaceReason = refusal.message();
}

std::string AtomicFile::Name() const {
    if (m_target == m_given) return Text("{}", m_given);
    return Text("{}, a link to {}", m_given, m_target);
}

void AtomicFile::Fail(const char* what, const std::error_code& error) const {
    throw MakeError(ErrorKind::Io, "{}: {}: {}", Name(), what, error.message());
}

void AtomicFile::FailToWrite(const std::error_code& error) {
    if (!m_writeError) m_writeError = error;
    Fail("cannot write", error);
}

std::FILE* AtomicFile::Stream() const {
    RG_CHECK(m_file != nullptr);
    return m_file->Stream();
}

void AtomicFile::Write(std::span<const std::byte> bytes) {
    errno = 0;
    if (std::fwrite(bytes.data(), 1, bytes.size(), Stream()) != bytes.size()) FailToWrite(os::LastError());
}

uint64_t AtomicFile::Position() const {
    std::error_code error;
    const uint64_t position = os::Position(Stream(), error);
    if (error) Fail("cannot tell the position", error);
    return position;
}

void AtomicFile::Seek(uint64_t position) {
    // Seeking writes out what is buffered, so it fails as a write does.
    std::error_code error;
    os::Seek(Stream(), position, error);
    if (error) FailToWrite(error);
}

void AtomicFile::Commit() {
    if (m_writeError) Fail("cannot write", m_writeError);
    std::error_code error;
    m_file->Close(error);
    if (error) Fail("cannot write", error);
    if (!m_isInPlace) {
        m_file->Publish(m_target.filename(), error);
        // The constructor has checked this, but not every system tells it.
        m_isInPlace = IsNameError(error);
        if (error && !m_isInPlace) Fail("cannot replace", error);
    }
    auto oldContent = os::OldContent::Kept;
    if (m_isInPlace) oldContent = m_file->CopyTo(m_target, error);
    if (oldContent == os::OldContent::Lost)
        throw IncompleteFile(ErrorKind::Io,
                             Text("{}: cannot write: {}; its old content is lost", Name(), error.message()));
    if (error == std::errc::timed_out && IsStream(m_target))
        throw MakeError(ErrorKind::Io, "{}: cannot write: nobody reads the pipe", Name());
    if (error) Fail("cannot write", error);
    m_file.reset();
}

std::string InPlaceWarning(const std::filesystem::path& target) {
    const AtomicFile probe(target);  // is dropped without Commit
    if (probe.InPlaceReason().empty()) return {};
    return Text("written in place, because it cannot be replaced: {}", probe.InPlaceReason());
}

// --- Reading a whole file, and the folder for data that can be made again ---

namespace {

void Check(const std::filesystem::path& path, const char* what, const std::error_code& error) {
    if (error) throw MakeError(ErrorKind::Io, "{}: {}: {}", path, what, error.message());
}

}  // namespace

std::vector<std::byte> ReadFile(const std::filesystem::path& path, uint64_t maxBytes) {
    std::error_code error;
    os::InputFile file(path, os::Links::Follow, error);
    Check(path, "cannot open", error);
    const std::optional<uint64_t> size = file.RegularSize(error);
    Check(path, "cannot read", error);
    if (!size) throw MakeError(ErrorKind::Io, "{}: cannot read: it is not a regular file", path);
    if (*size > maxBytes)
        throw MakeError(ErrorKind::BadInput, "{}: {} bytes exceed the limit of {}", path, *size, maxBytes);
    std::vector<std::byte> bytes;
    try {
        bytes.resize(*size);
    } catch (const std::bad_alloc&) {
        throw MakeError(ErrorKind::OutOfMemory, "{}: no memory for {} bytes", path, *size);
    }
    // A file that shrinks meanwhile is read up to its new end.
    const size_t filled = file.Read(bytes, error);
    Check(path, "cannot read", error);
    bytes.resize(filled);
    return bytes;
}

std::filesystem::path CacheFolder() {
    // By the XDG specification, a relative path in the variable counts as unset.
    const char* cache = std::getenv("XDG_CACHE_HOME");
    if (cache && std::filesystem::path(cache).is_absolute()) return std::filesystem::path(cache) / "raygraph";
    const char* home = std::getenv("HOME");
    if (home && *home) return std::filesystem::path(home) / ".cache" / "raygraph";
    return {};
}

}  // namespace raygraph
