// Does work beside the window, one task after another on a thread of its own; the main thread then says how
// it went. Threads: the main thread's.
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
    // What is left to be done on the main thread.
    using Finish = std::function<void()>;
    // Runs on the other thread. May throw.
    using Task = std::function<Finish()>;
    // Called on the main thread instead of a Finish: what was thrown, one line.
    using Fail = std::function<void(const std::string& why)>;

    Worker() = default;
    ~Worker();  // waits for all tasks; nothing is called on the main thread any more
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    void Add(Task task, Fail fail);
    // Calls what is due on this thread. Never waits for a task.
    void FinishTasks();
    // Whether there are tasks that were not finished so.
    bool IsBusy() const { return m_unfinished > 0; }

  private:
    struct Entry {
        Task task;
        Fail fail;
    };
    void Run();

    std::thread m_thread;     // since the first task
    size_t m_unfinished = 0;  // of the main thread
    mutable std::mutex m_mutex;
    std::condition_variable m_hasChanged;
    // Guarded
    bool m_isEnding = false;
    std::deque<Entry> m_tasks;
    std::vector<Finish> m_due;
};

}  // namespace raygraph::editor
