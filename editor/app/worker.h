// Worker runs tasks one after another on a thread of its own, and their completions on the main thread.
// Threads: main thread only.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace raygraph::editor {

class Worker {
  public:
    // Completes a task on the main thread.
    using Finish = std::function<void()>;
    // Runs on the worker's thread. It may throw.
    using Task = std::function<Finish()>;
    // Is called on the main thread, in place of Finish, with one line of what was thrown.
    using Fail = std::function<void(const std::string& why)>;

    Worker() = default;
    ~Worker();  // waits for all tasks; calls no more Finish or Fail
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    void Add(Task task, Fail fail);
    // Calls the pending Finish and Fail functions. It never waits for a task.
    void FinishTasks();
    // Returns whether there are tasks whose completion has not run.
    bool IsBusy() const { return m_unfinished > 0; }

  private:
    struct Entry {
        Task task;
        Fail fail;
    };
    void Run();

    std::thread m_thread;     // started by the first task
    size_t m_unfinished = 0;  // read and written on the main thread
    mutable std::mutex m_mutex;
    std::condition_variable m_hasChanged;
    // guarded by m_mutex
    bool m_isEnding = false;
    std::deque<Entry> m_tasks;
    std::vector<Finish> m_due;
};

}  // namespace raygraph::editor
