#include "base/read_file.h"

#include <new>
#include <optional>
#include <string>
#include <system_error>

#include "base/error.h"
#include "base/os/file.h"

namespace raygraph {
namespace {

void Check(const std::filesystem::path& path, const char* what, const std::error_code& error) {
    if (error) throw Error(ErrorKind::Io, path.string() + ": " + what + ": " + error.message());
}

}  // namespace

std::vector<std::byte> ReadFile(const std::filesystem::path& path, uint64_t maxBytes) {
    std::error_code error;
    os::InputFile file(path, os::Links::Follow, error);
    Check(path, "cannot open", error);
    const std::optional<uint64_t> size = file.RegularSize(error);
    Check(path, "cannot read", error);
    if (!size) throw Error(ErrorKind::Io, path.string() + ": cannot read: it is not a regular file");
    if (*size > maxBytes) {
        throw Error(ErrorKind::BadInput, path.string() + ": " + std::to_string(*size) +
                                             " bytes exceed the limit of " + std::to_string(maxBytes));
    }
    std::vector<std::byte> bytes;
    try {
        bytes.resize(*size);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::OutOfMemory,
                    path.string() + ": no memory for " + std::to_string(*size) + " bytes");
    }
    // A file that shrinks meanwhile is read as far as it goes.
    const size_t filled = file.Read(bytes, error);
    Check(path, "cannot read", error);
    bytes.resize(filled);
    return bytes;
}

}  // namespace raygraph
