// New files that take the place of others at once, for base/atomic_file.h, which other code should use.
// Nothing here throws: failures are error codes. Threads: one object is for one thread at a time.
#pragma once

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

namespace raygraph::os {

// Says whether the previous content of the file was still intact when a write in place failed.
enum class OldContent : bool { Kept, Lost };

// An empty file for writing and reading, which nobody else sees until Publish. It has no name where the file
// system allows that, so that a killed process leaves nothing. Elsewhere its name begins with ".raygraph-"
// and the file is locked while it is written; the next process that makes a NewFile in the folder removes
// files whose lock is free. Those of another computer, whose locks may not be seen here, must be a day old
// for that.
class NewFile {
  public:
    // `folder`: "" is the current one. `permissions` take the place of the defaults of new files, if they can
    // be set.
    NewFile(const std::filesystem::path& folder, std::optional<std::filesystem::perms> permissions,
            std::error_code& error);
    ~NewFile();
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    // Returns null if the constructor failed, and after Close.
    std::FILE* Stream() const { return m_stream; }

    // Waits until all is on the disk, and closes the stream.
    void Close(std::error_code& error);
    // Publish and CopyTo are called after Close. Publish gives the file a name in its folder, in place of
    // whatever has it, at once: where the system gives none to a file without a name, a copy that has one
    // takes its place.
    void Publish(const std::filesystem::path& name, std::error_code& error);
    // Copies the content into a regular file, which is created if there is none, a device or a pipe. Room in
    // a regular file is made first, so that a full disk is found before any of its old content is
    // overwritten. It has a part of the content until this returns, and where a write then fails all the
    // same, as on a broken disk, or on a full file system that copies what is overwritten: only then its old
    // content is lost. A pipe without a reader is waited for, half a minute, and then is an error,
    // std::errc::timed_out. A reader may take its time, but a process that is asked to end (SignalWatch)
    // waits only two seconds more for either.
    OldContent CopyTo(const std::filesystem::path& target, std::error_code& error) const;

  private:
    bool OpenNamed(std::error_code& error);
    std::error_code Link(const std::string& name) const;
    bool CopyToNamed(std::error_code& error);

    int m_folder = -1;
    int m_descriptor = -1;  // It holds the lock, and outlives the stream.
    std::string m_name;     // It is empty while the file has no name of its own.
    std::FILE* m_stream = nullptr;
};

// Returns the reason for which Publish could not replace this existing file, if its status, that of its
// folder and the rights of this process tell: for example that it is a folder, a mount point, immutable, or
// another user's in a folder that all share. Nothing is changed or tried.
std::error_code RefusalToReplace(const std::filesystem::path& file);

// Returns the reason for which CopyTo could not write to this existing file, device or pipe. A device or a
// pipe is not opened: a pipe may lack its reader for now.
std::error_code RefusalToWrite(const std::filesystem::path& file);

}  // namespace raygraph::os
