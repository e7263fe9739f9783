#include "base/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <string>
#include <system_error>

#include "base/error.h"

namespace raygraph {
namespace {

class Descriptor {
  public:
    explicit Descriptor(int number) : m_number(number) {}
    ~Descriptor() {
        if (m_number >= 0) close(m_number);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int Number() const { return m_number; }

  private:
    int m_number;
};

[[noreturn]] void Fail(const std::filesystem::path& path, const char* what, int systemError) {
    const std::string reason = std::generic_category().message(systemError);
    throw Error(ErrorKind::Io, path.string() + ": " + what + ": " + reason);
}

}  // namespace

std::vector<std::byte> ReadFile(const std::filesystem::path& path, uint64_t maxBytes) {
    // O_NONBLOCK: opening a pipe that nobody writes to must not wait; it means nothing to a regular file.
    const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
    if (file.Number() < 0) Fail(path, "cannot open", errno);
    struct stat status = {};
    if (fstat(file.Number(), &status) != 0) Fail(path, "cannot read", errno);
    if (!S_ISREG(status.st_mode)) {
        throw Error(ErrorKind::Io, path.string() + ": cannot read: it is not a regular file");
    }
    const auto size = static_cast<uint64_t>(status.st_size);
    if (size > maxBytes) {
        throw Error(ErrorKind::BadInput, path.string() + ": " + std::to_string(size) +
                                             " bytes exceed the limit of " + std::to_string(maxBytes));
    }
    std::vector<std::byte> bytes;
    try {
        bytes.resize(size);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::OutOfMemory,
                    path.string() + ": no memory for " + std::to_string(size) + " bytes");
    }
    // A file that shrinks meanwhile is read as far as it goes.
    size_t filled = 0;
    while (filled < bytes.size()) {
        const ssize_t got = read(file.Number(), bytes.data() + filled, bytes.size() - filled);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) Fail(path, "cannot read", errno);
        if (got == 0) break;
        filled += static_cast<size_t>(got);
    }
    bytes.resize(filled);
    return bytes;
}

}  // namespace raygraph
