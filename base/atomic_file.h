// A file that is written as a whole or not at all. Threads: one object is for one thread at a time; different
// ones share nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <system_error>

#include "base/api.h"

namespace raygraph {

// Opens a new file of a unique name beside `target`; Commit() moves it over the target. Until then the target
// is as it was, and the destructor removes the new file. A target that is a symbolic link is followed; one
// that exists and is not a regular file (a folder, a device) is refused; an existing target's permissions are
// kept. Every failure is Error{Io} naming the target and the system's reason. One object is for one thread at
// a time.
class RAYGRAPH_API AtomicFile {
  public:
    explicit AtomicFile(const std::filesystem::path& target);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    void Write(std::span<const std::byte> bytes);
    // Positions are in bytes from the start of the file.
    uint64_t Position() const;
    void Seek(uint64_t position);

    // For libraries that write to a stdio stream. Owned by this object; errors on it are found by Commit().
    std::FILE* Stream() const { return m_stream; }

    // Flushes to the disk and renames. Fails if any earlier write failed. At most once, as the last call.
    void Commit();

  private:
    [[noreturn]] void Fail(const char* what, const std::error_code& error) const;

    std::filesystem::path m_target, m_temporary;
    std::FILE* m_stream = nullptr;
    bool m_isWriteFailed = false;
};

}  // namespace raygraph
