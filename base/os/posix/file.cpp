#include "base/os/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "base/os/last_error.h"

namespace raygraph::os {

InputFile::InputFile(const std::filesystem::path& path, Links links, std::error_code& error) {
    // O_NONBLOCK means nothing to a regular file
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

}  // namespace raygraph::os
