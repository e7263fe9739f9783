#include "base/read_file.h"

#include <new>
#include <optional>
#include <system_error>

#include "base/os.h"
#include "base/path_text.h"
#include "base/text.h"

namespace raygraph {
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
    // A file that shrinks meanwhile is read as far as it goes.
    const size_t filled = file.Read(bytes, error);
    Check(path, "cannot read", error);
    bytes.resize(filled);
    return bytes;
}

}  // namespace raygraph
