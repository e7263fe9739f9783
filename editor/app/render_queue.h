// RenderQueue renders pictures by child processes, `raygraph render`, one after another. They share neither
// memory nor a device with the editor, which goes on beside them, and which a lost device or too large a
// picture would end. Threads: main thread only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/os.h"
#include "editor/app/file_content.h"

namespace raygraph::editor {

// Removes a file's folder, with all that is in it, once nobody needs the file. SweepCopies removes what an
// editor that was killed has left.
class PrivateCopy {
  public:
    explicit PrivateCopy(std::filesystem::path file) : m_file(std::move(file)) {}
    ~PrivateCopy();
    PrivateCopy(const PrivateCopy&) = delete;
    PrivateCopy& operator=(const PrivateCopy&) = delete;
    const std::filesystem::path& File() const { return m_file; }

  private:
    std::filesystem::path m_file;
};

// Removes the folders in `folder` that nobody has changed for a week.
void SweepCopies(const std::filesystem::path& folder);

struct RenderTask {
    std::vector<std::string> command;  // the program and its arguments, with `--progress json`
    std::string name;                  // for people: the outputs
    std::vector<std::filesystem::path> outputs = {};
    uint32_t pictures = 1;                         // frames times cameras
    std::shared_ptr<const PrivateCopy> copy = {};  // the scene, if it has unsaved edits
    // The scene otherwise, as it was when the task was made: another content is not rendered. None: any is.
    std::filesystem::path scene = {};
    std::optional<FileStamp> stamp = {};
};

// Holds what the events of `--progress json` have told (docs/cli.md).
struct RenderProgress {
    std::string text = "starting";
    float fraction = 0.0f;  // of the picture, 0 to 1; 0 while unknown
    uint32_t written = 0;   // pictures whose files are complete
};
// Reads a line of the program. Returns false, and changes nothing, if it is no event.
bool ReadProgress(std::string_view line, RenderProgress& progress);

class RenderQueue {
  public:
    //   Stopped:   its files have the samples that there were
    //   Cancelled: a picture that was not complete has no file
    enum class State : uint8_t { Waiting, Running, Done, Stopped, Cancelled, Failed };
    struct Job {
        RenderTask task;
        State state = State::Waiting;
        RenderProgress progress;
        std::string result;  // one line; "" before its end
        bool IsOver() const { return state > State::Running; }
        float Fraction() const;  // of all its pictures
    };

    RenderQueue() = default;
    ~RenderQueue();  // cancels all

    RenderQueue(const RenderQueue&) = delete;
    RenderQueue& operator=(const RenderQueue&) = delete;

    void Add(RenderTask task);
    // Reads the progress of the running job, and starts the next one; called once a frame. Does not wait.
    // Returns the job that has ended; null: none has.
    const Job* Update();
    // Ends a job that is not over; files of its names stay as they are.
    void Cancel(size_t job);
    // Lets a running job write the samples that it has so far.
    void Stop(size_t job);
    void RemoveOver();  // forgets the jobs that are over
    // Returns whether a job that is not over has an output of this name.
    bool IsWriting(const std::filesystem::path& file) const;
    uint64_t AddedCount() const { return m_addedCount; }  // since the start
    const std::vector<Job>& Jobs() const { return m_jobs; }
    const Job* Running() const;  // null: none is
    bool IsBusy() const;         // a job is not over

  private:
    void ReadLines(Job& job);
    void ReadLine(Job& job, std::string_view line);
    void End(Job& job);
    void Start(Job& job);

    std::vector<Job> m_jobs;                      // in the order in which they were added
    std::unique_ptr<os::ChildProcess> m_process;  // renders the running job
    std::string m_unread;                         // the start of a line that it has not ended yet
    std::string m_lastMessage;                    // its last line that is no event
    uint64_t m_addedCount = 0;
    bool m_isStopping = false;
};

const char* Name(RenderQueue::State state);

}  // namespace raygraph::editor
