#include "renderer/scene/file_access.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "base/error.h"
#include "base/printable.h"
#include "renderer/scene/uri.h"

namespace raygraph::scene {
namespace {

std::string SystemMessage(int code) {
    return std::generic_category().message(code);
}

[[noreturn]] void FailRead(const std::filesystem::path& path, const std::string& why) {
    throw Error(ErrorKind::Io, Printable(path.string(), 1024) + ": " + why);
}

class FileDescriptor {
  public:
    explicit FileDescriptor(int fd) : m_fd(fd) {}
    ~FileDescriptor() {
        if (m_fd >= 0) close(m_fd);
    }
    FileDescriptor(const FileDescriptor&) = delete;
    FileDescriptor& operator=(const FileDescriptor&) = delete;
    int Value() const { return m_fd; }

  private:
    int m_fd;
};

[[noreturn]] void FailUri(std::string_view uri, const std::string& why) {
    throw Error(ErrorKind::BadInput, Quoted(uri) + ": " + why);
}

bool IsInside(const std::filesystem::path& path, const std::filesystem::path& folder) {
    const auto [folderEnd, pathAt] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
    return folderEnd == folder.end() && pathAt != path.end();
}

}  // namespace

std::filesystem::path RelativePath(std::string_view uri) {
    if (uri.empty()) FailUri(uri, "is empty");
    if (UriScheme(uri)) FailUri(uri, "must be a relative path or a data URI, not " + Quoted(*UriScheme(uri)));
    const std::string text = PercentDecode(uri);
    if (text.find('\0') != std::string::npos) FailUri(uri, "contains a zero byte");
    if (text.find('\\') != std::string::npos) FailUri(uri, "contains a backslash");
    // Once more after decoding: "c%3A..." must not become a drive.
    if (UriScheme(text)) FailUri(uri, "must be a relative path or a data URI");
    std::filesystem::path path(text);
    if (path.is_absolute()) FailUri(uri, "must be a relative path, not an absolute one");
    for (const auto& part : path)
        if (part == "..") FailUri(uri, "leads out of the scene's folder (\"..\")");
    return path;
}

std::vector<std::byte> DiskFileReader::Read(const std::filesystem::path& path, uint64_t maxBytes) {
    // Asked before opening, because opening a device can have effects; asked again of what was opened.
    std::error_code error;
    const auto status = std::filesystem::symlink_status(path, error);
    if (error) FailRead(path, error.message());
    if (status.type() == std::filesystem::file_type::not_found) FailRead(path, SystemMessage(ENOENT));
    if (status.type() != std::filesystem::file_type::regular) FailRead(path, "is not a regular file");
    const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW | O_NOCTTY));
    if (file.Value() < 0) FailRead(path, SystemMessage(errno));
    struct stat info {};
    if (fstat(file.Value(), &info) != 0) FailRead(path, SystemMessage(errno));
    if (!S_ISREG(info.st_mode)) FailRead(path, "is not a regular file");
    const auto size = static_cast<uint64_t>(info.st_size);
    if (size > maxBytes)
        FailRead(path, std::to_string(size) + " bytes exceed the limit of " + std::to_string(maxBytes));

    std::vector<std::byte> bytes(size);
    size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t got = read(file.Value(), bytes.data() + done, bytes.size() - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) FailRead(path, SystemMessage(errno));
        if (got == 0)
            FailRead(path, "ended after " + std::to_string(done) + " bytes, changed while being read");
        done += static_cast<size_t>(got);
    }
    return bytes;
}

ConfinedFolder::ConfinedFolder(const std::filesystem::path& folder, FileReader& reader) : m_reader(&reader) {
    std::error_code error;
    m_folder = std::filesystem::canonical(folder.empty() ? "." : folder, error);
    if (error) FailRead(folder, error.message());
}

std::vector<std::byte> ConfinedFolder::Read(std::string_view uri, uint64_t maxBytes) const {
    const std::filesystem::path relative = RelativePath(uri);
    std::error_code error;
    const std::filesystem::path path = std::filesystem::canonical(m_folder / relative, error);
    if (error) FailUri(uri, error.message());
    if (!IsInside(path, m_folder)) FailUri(uri, "leads out of the scene's folder");
    try {
        return m_reader->Read(path, maxBytes);
    } catch (const Error& failure) {
        // The reader's message starts with the whole path; the scene's author knows the URI.
        const std::string prefix = Printable(path.string(), 1024) + ": ";
        const std::string message = failure.what();
        FailUri(uri, message.starts_with(prefix) ? message.substr(prefix.size()) : message);
    }
}

}  // namespace raygraph::scene
