// The functions of the operating system: files as it opens them, libraries, this process, its terminal and
// signals. No other code of the product includes a header of the system (tests/layering), so a port to
// another system is another file beside os_posix.cpp. Functions on files report by std::error_code and throw
// nothing; callers decide what an error means, and name the file. For base/ and programs alone.
// Threads: any, unless said otherwise; one object is for one thread at a time.
#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/api.h"

namespace raygraph::os {

// ---------------------------------------------------------------------------------------------- errors

// Returns errno; an input/output error where the call has left no reason, as stdio may.
inline std::error_code LastError() {
    return {errno != 0 ? errno : EIO, std::generic_category()};
}

// ----------------------------------------------------------------------------------------------- files

enum class Links : bool { Follow, Refuse };  // at the end of a path

// InputFile is a file that is open for reading. Opening does not block (as a pipe without a writer would) and
// has no effect on this process (a terminal does not become its controlling one).
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

// Positions in a stream are in bytes from its start. Seeking flushes the buffer.
uint64_t Position(std::FILE* stream, std::error_code& error);
void Seek(std::FILE* stream, uint64_t position, std::error_code& error);

// ------------------------------------------------------------------------------------------- new files

// Says whether the previous content of the file was still intact when a write in place failed.
enum class OldContent : bool { Kept, Lost };

// NewFile is an empty file for writing and reading, which no other process sees until Publish. It has no name
// where the file system allows that, so that a killed process leaves nothing. Elsewhere its name begins with
// ".raygraph-" and the file is locked while it is written; the next process that makes a NewFile in the
// folder removes files whose lock is free. Files of another computer, whose locks may not be seen here, must
// be a day old for that.
class NewFile {
  public:
    // `folder` may be "", the current one. `permissions` take the place of the defaults of new files, if they
    // can be set.
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
    int m_descriptor = -1;  // holds the lock, and outlives the stream
    std::string m_name;     // empty while the file has no name of its own
    std::FILE* m_stream = nullptr;
};

// Returns the reason for which Publish could not replace this existing file, if its status, that of its
// folder and the rights of this process tell: for example that it is a folder, a mount point, immutable, or
// another user's in a folder that all share. Nothing is changed or tried.
std::error_code CheckReplaceable(const std::filesystem::path& file);

// Returns the reason for which CopyTo could not write to this existing file, device or pipe. A device or a
// pipe is not opened: a pipe may lack its reader for now.
std::error_code CheckOverwritable(const std::filesystem::path& file);

// ------------------------------------------------------------------------------------------- libraries

// Loads a library by its file name, to the end of the process: nothing is unloaded, because other code may
// still run in it. Returns null and sets the reason if it cannot be loaded.
void* OpenLibrary(const char* name, std::string& whyNot);
// Returns null if the library has no function of that name.
void* FunctionOf(void* library, const char* name);

// --------------------------------------------------------------------------------------- the allocator

// Gives large blocks pages of their own, which go back to the system with each, where the allocator can.
// Otherwise, a program that has loaded a scene may at any time give back hundreds of megabytes at once, for
// which a thread that allocates waits. For programs, not for libraries.
RAYGRAPH_API void MapLargeBlocks() noexcept;

// ----------------------------------------------------------------------- this process and its terminal

// Returns the processor time of all threads, user and system, in seconds. A CPU driver renders in this
// process.
double ProcessCpuSeconds();
// Returns the peak of the resident memory, in bytes.
uint64_t PeakResidentBytes();

// Returns the wall-clock time in this computer's time zone: "14:05:09".
std::string LocalTimeOfDay();

// Lets writes fail instead of ending the process: those to a pipe without a reader, and those beyond the
// limit on the size of files (SIGPIPE, SIGXFSZ). Those to a standard stream that is closed fail, too, and
// never go to a file that is opened in its place. For programs, at their start.
void IgnoreWriteSignals() noexcept;

bool IsTerminal(std::FILE* stream);
// Returns the columns of the terminal; 80 if unknown.
size_t TerminalWidth(std::FILE* stream);

// Returns whether a text matches a shell pattern: * ? [a-z].
bool MatchesPattern(const std::string& text, const std::string& pattern);

// -------------------------------------------------------------------------------------- other programs

// Returns whether the program is in one of the folders of PATH.
bool FindProgram(const std::string& name);
// Returns the file of the program that runs in this process; "" if the system does not tell.
std::filesystem::path ProgramFile();
// Returns a word of a command line for a POSIX shell, in quotes where it would take it apart or change it.
RAYGRAPH_API std::string ForShell(const std::string& word);
// Says where a child's stderr goes: where that of this process goes, or to what is read from the child.
enum class ErrorStream : bool { Inherited, WithOutput };
// ChildProcess runs a program of PATH, or of a path, with its arguments, without a shell. Its destructor asks
// it to end, and waits for that. The end of the thread that has made it asks it, too (SIGTERM), also where
// this process is killed.
class ChildProcess {
  public:
    explicit ChildProcess(const std::vector<std::string>& command,
                          ErrorStream errors = ErrorStream::Inherited);
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    // Reads what the program has written. Returns whether it has not ended yet; does not block.
    bool IsRunning();
    // Returns whether there is, or was, such a process: the program was found, and could be started.
    bool IsStarted() const { return m_isStarted; }
    // Returns what it has written until the last IsRunning, and was not taken before.
    std::string TakeWritten() { return std::exchange(m_written, {}); }
    // Returns all that it has written and was not taken; none if it could not be started or ended with
    // another status than 0. For after its end.
    std::optional<std::string> Output() const {
        return m_status == 0 ? std::optional(m_written) : std::nullopt;
    }
    // Returns with which status it has ended; none if it could not be started or a signal has ended it.
    std::optional<int> ExitStatus() const { return m_status; }
    void Terminate();  // asks it to end (SIGTERM); does not wait
    void Kill();       // ends it, whatever it does

  private:
    void Reap();

    int m_process = 0;  // 0: it has ended
    bool m_isStarted = false;
    int m_pipe = -1;
    std::string m_written;
    std::optional<int> m_status;
};

// --------------------------------------------------------------------------------------------- signals

// Notes signals instead of letting them end the process at once, so that a render can write its samples:
// SIGINT (Ctrl-C); to end, SIGTERM, SIGUSR2, by which clusters say that a job is about to be ended, SIGHUP of
// a closed terminal and SIGXCPU of a limit on processor time; SIGUSR1, by which clusters ask it to save. A
// second SIGINT ends the process as usual. One that the process was started to ignore, as by nohup or in the
// background of a script, stays ignored. One object at a time.
class SignalWatch {
  public:
    // Until StartDeferring there is nothing to save: SIGINT ends the process as usual, the signals to end
    // call `onTermination` in their handler. SIGUSR1 is noted from the start.
    explicit SignalWatch(void (*onTermination)());
    ~SignalWatch();
    SignalWatch(const SignalWatch&) = delete;
    SignalWatch& operator=(const SignalWatch&) = delete;

    void StartDeferring();

    bool IsInterrupted() const;    // returns whether SIGINT was noted
    bool IsTerminated() const;     // returns whether one of the signals to end was noted
    bool IsSaveRequested() const;  // returns whether SIGUSR1 was noted since the last ClearSaveRequest
    void ClearSaveRequest();

  private:
    struct Before;
    std::unique_ptr<Before> m_before;
};

// Returns whether the SignalWatch, if there is one, has noted SIGINT or a signal to end.
bool IsStopRequested();

}  // namespace raygraph::os
