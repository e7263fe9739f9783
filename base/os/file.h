// Files of the operating system, for base/read_file.h and base/atomic_file.h, which other code should use;
// new ones are in new_file.h.
// Nothing here throws: failures are error codes. Threads: one object is for one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <span>
#include <system_error>

namespace raygraph::os {

enum class Links : bool { Follow, Refuse };  // at the end of a path

// A file that is open for reading. Opening does not block (as a pipe without a writer would) and has no
// effect on this process (a terminal does not become its controlling one).
class InputFile {
  public:
    InputFile(const std::filesystem::path& path, Links links, std::error_code& error);
    ~InputFile();
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    // Returns the bytes of a regular file at this time; none if it is not a regular file (a folder, a device,
    // a pipe).
    std::optional<uint64_t> RegularSize(std::error_code& error) const;
    // Fills `bytes` from where the last call ended. Returns how many it filled: fewer where the file ends.
    size_t Read(std::span<std::byte> bytes, std::error_code& error);

  private:
    int m_descriptor = -1;
};

// Positions in a stream, bytes from its start. Seeking flushes the buffer.
uint64_t Position(std::FILE* stream, std::error_code& error);
void Seek(std::FILE* stream, uint64_t position, std::error_code& error);

}  // namespace raygraph::os
