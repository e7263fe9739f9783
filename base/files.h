// Files on disk: AtomicFile writes one as a whole or not at all, ReadFile reads one into memory, CacheFolder
// is where programs keep data that can be made again, LowerExtension tells formats apart. Threads: one
// AtomicFile is for one thread at a time, and different ones share nothing; the functions may be called from
// any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "base/api.h"
#include "base/error.h"

namespace raygraph {

namespace os {
class NewFile;
}

// Is thrown if a write in place (AtomicFile::InPlaceReason) has failed midway: part of the new content has
// overwritten the old content.
class RAYGRAPH_API IncompleteFile : public Error {
  public:
    using Error::Error;
};

// Collects what is written in a new file, which Commit() puts in the place of `target`. Until then the target
// is as it was, and nothing is left where the object ends, or the process is killed, before that. A target
// that is a symbolic link is followed; an existing target's permissions are kept.
//
// The constructor fails where Commit() would, unless the disk fills up in between; an object that is made
// only to check this leaves no trace. A target that can be written but not replaced (InPlaceReason) is
// written in place by Commit(), and so are streams (IsStream), which the constructor does not open; Commit()
// waits for the reader of a pipe (os::NewFile::CopyTo). A folder is refused. Every failure is Error{Io}
// naming the target, the link to it if that was given, and the system's reason.
class RAYGRAPH_API AtomicFile {
  public:
    explicit AtomicFile(const std::filesystem::path& target);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    // Returns the reason for which a regular file is not replaced as a whole, such as that it is mounted by
    // itself; "" means that it is. Commit() then overwrites it, once there is room for the whole: a full disk
    // leaves the old content. A crash while it does so leaves a part of the new content; so does a disk that
    // fails, which is an IncompleteFile.
    const std::string& InPlaceReason() const { return m_inPlaceReason; }

    // Returns whether it is a device or a pipe, which gets content after content: it is never replaced, and
    // keeps nothing.
    static bool IsStream(const std::filesystem::path& target);

    void Write(std::span<const std::byte> bytes);
    // Positions are in bytes from the start of the file.
    uint64_t Position() const;
    void Seek(uint64_t position);

    // Flushes to the disk and replaces the target. Fails if any earlier write failed. It is called at most
    // once, as the last call.
    void Commit();

  private:
    std::FILE* Stream() const;
    [[noreturn]] void Fail(const char* what, const std::error_code& error) const;
    [[noreturn]] void FailToWrite(const std::error_code& error);
    void FollowLinks();
    void OpenReplacement();

    // Returns "given", or "given, a link to target", as messages name it.
    std::string Name() const;

    std::filesystem::path m_given, m_target;
    std::unique_ptr<os::NewFile> m_file;  // null after Commit
    bool m_isInPlace = false;
    std::error_code m_writeError;  // reason of the first write that failed
    std::string m_inPlaceReason;
};

// Throws what the constructor of AtomicFile would throw for this target. Otherwise returns a text that says
// that the file will be written in place, and why; "" if it will be replaced as a whole. Leaves no trace.
RAYGRAPH_API std::string InPlaceWarning(const std::filesystem::path& target);

// Reads a regular file (links are followed; folders, devices and pipes are refused) of at most
// `maxBytes` bytes. Error{Io} naming the path and the system's reason; Error{BadInput} for a longer
// file; Error{OutOfMemory}.
RAYGRAPH_API std::vector<std::byte> ReadFile(const std::filesystem::path& path,
                                             uint64_t maxBytes = uint64_t{1} << 32);

// Returns the folder in which programs of this user keep data that can be made again:
// $XDG_CACHE_HOME/raygraph, else ~/.cache/raygraph; empty if there is neither variable. It may not exist
// yet.
RAYGRAPH_API std::filesystem::path CacheFolder();

// Returns the extension of a file's name with its dot, in lower case: ".png" for "A.PNG"; "" if there is
// none.
inline std::string LowerExtension(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return extension;
}

}  // namespace raygraph
