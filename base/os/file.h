// Files as the operating system has them; base/read_file.h and base/atomic_file.h are for use. Nothing here
// throws: what fails says so by a code. Threads: one object is for one thread at a time.
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

// A file that is open for reading. Opening one waits for nobody (a pipe without a writer) and has no effect
// on this process (a terminal does not become its own).
class InputFile {
  public:
    InputFile(const std::filesystem::path& path, Links links, std::error_code& error);
    ~InputFile();
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    // Bytes of a regular file, as of now; none for what is no regular file (a folder, a device, a pipe).
    std::optional<uint64_t> RegularSize(std::error_code& error) const;
    // Fills `bytes` from where the last call ended. Returns how many it filled: fewer where the file ends.
    size_t Read(std::span<std::byte> bytes, std::error_code& error);

  private:
    int m_descriptor = -1;
};

// A name for a file in `folder` that no other thread or process uses, unless they try to.
std::filesystem::path TemporaryName(const std::filesystem::path& folder);

// A new file, for writing and reading; an error if there is one of that name, even a link. `permissions`:
// other than those that new files get, if they can be had.
std::FILE* CreateNew(const std::filesystem::path& path, std::optional<std::filesystem::perms> permissions,
                     std::error_code& error);

// Places in a stream, bytes from its start. Moving writes out what is buffered.
uint64_t Position(std::FILE* stream, std::error_code& error);
void Seek(std::FILE* stream, uint64_t position, std::error_code& error);
// Waits until what was flushed is on the disk; a file system that cannot tell is no error.
void Sync(std::FILE* stream, std::error_code& error);

}  // namespace raygraph::os
