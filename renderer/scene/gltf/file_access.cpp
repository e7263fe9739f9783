#include "renderer/scene/gltf/file_access.h"

#include <algorithm>
#include <optional>
#include <system_error>

#include "base/os.h"
#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/gltf/container.h"

namespace raygraph::scene {
namespace {

[[noreturn]] void FailRead(const std::filesystem::path& path, const std::string& why) {
    throw MakeError(ErrorKind::Io, "{}: {}", path, why);
}

[[noreturn]] void FailUri(std::string_view uri, const std::string& why) {
    throw MakeError(ErrorKind::BadInput, "{}: {}", Quoted(uri), why);
}

bool IsInside(const std::filesystem::path& path, const std::filesystem::path& folder) {
    const auto [folderEnd, pathAt] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
    return folderEnd == folder.end() && pathAt != path.end();
}

std::filesystem::path CanonicalFolder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::path canonical = std::filesystem::canonical(folder.empty() ? "." : folder, error);
    if (error) FailRead(folder, error.message());
    if (!std::filesystem::is_directory(canonical, error)) FailRead(folder, "is not a folder");
    return canonical;
}

}  // namespace

std::filesystem::path RelativePath(std::string_view uri) {
    if (uri.empty()) FailUri(uri, "is empty");
    if (const auto scheme = UriScheme(uri))
        FailUri(uri, Text("must be a relative path or a data URI, not {}", Quoted(*scheme)));
    const std::string text = PercentDecode(uri);
    if (text.find('\0') != std::string::npos) FailUri(uri, "contains a zero byte");
    if (text.find('\\') != std::string::npos) FailUri(uri, "contains a backslash");
    // The check is repeated after decoding: "c%3A..." must not become a drive.
    if (UriScheme(text)) FailUri(uri, "must be a relative path or a data URI");
    std::filesystem::path path(text);
    if (path.is_absolute()) FailUri(uri, "must be a relative path, not an absolute one");
    return path.lexically_normal();
}

std::vector<std::byte> DiskFileReader::Read(const std::filesystem::path& path, uint64_t maxBytes) {
    // The type is checked before opening, because opening a device can have effects, and again after it.
    std::error_code error;
    const auto status = std::filesystem::symlink_status(path, error);
    if (error) FailRead(path, error.message());
    if (status.type() == std::filesystem::file_type::not_found)
        FailRead(path, std::make_error_code(std::errc::no_such_file_or_directory).message());
    if (status.type() != std::filesystem::file_type::regular) FailRead(path, "is not a regular file");
    os::InputFile file(path, os::Links::Refuse, error);
    if (error) FailRead(path, error.message());
    const std::optional<uint64_t> size = file.RegularSize(error);
    if (error) FailRead(path, error.message());
    if (!size) FailRead(path, "is not a regular file");
    if (*size > maxBytes) FailRead(path, Text("{} bytes exceed the limit of {}", *size, maxBytes));

    std::vector<std::byte> bytes(*size);
    const size_t done = file.Read(bytes, error);
    if (error) FailRead(path, error.message());
    if (done < bytes.size()) FailRead(path, Text("ended after {} bytes, changed while being read", done));
    return bytes;
}

ConfinedFolder::ConfinedFolder(const std::filesystem::path& folder, FileReader& reader,
                               const std::filesystem::path& root)
    : m_folder(CanonicalFolder(folder)),
      m_root(root.empty() ? m_folder : CanonicalFolder(root)),
      m_reader(&reader) {}

void ConfinedFolder::RequireInside(std::string_view uri, const std::filesystem::path& path) const {
    if (IsInside(path, m_folder) || IsInside(path, m_root)) return;
    FailUri(uri, m_root == m_folder
                     ? "leads out of the scene's folder; --root FOLDER allows what is below another folder"
                     : Text("leads out of the scene's folder and of the root {}", Quoted(m_root.string())));
}

std::vector<std::byte> ConfinedFolder::Read(std::string_view uri, uint64_t maxBytes) const {
    const std::filesystem::path named = (m_folder / RelativePath(uri)).lexically_normal();
    RequireInside(uri, named);
    std::error_code error;
    const std::filesystem::path path = std::filesystem::canonical(named, error);
    if (error) FailUri(uri, error.message());
    RequireInside(uri, path);
    try {
        return m_reader->Read(path, maxBytes);
    } catch (const Error& failure) {
        // The reader's message starts with the whole path; the scene's author knows the URI.
        const std::string prefix = Text("{}: ", path);
        const std::string message = failure.what();
        FailUri(uri, message.starts_with(prefix) ? message.substr(prefix.size()) : message);
    }
}

}  // namespace raygraph::scene
