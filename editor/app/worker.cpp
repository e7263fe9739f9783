#include "editor/app/worker.h"

#include <exception>
#include <utility>

namespace raygraph::editor {

Worker::~Worker() {
    {
        const std::scoped_lock lock(m_mutex);
        m_isEnding = true;
    }
    m_hasChanged.notify_one();
    if (m_thread.joinable()) m_thread.join();
}

void Worker::Add(Task task, Fail fail) {
    if (!m_thread.joinable()) m_thread = std::thread([this] { Run(); });
    {
        const std::scoped_lock lock(m_mutex);
        m_tasks.push_back({std::move(task), std::move(fail)});
    }
    ++m_unfinished;
    m_hasChanged.notify_one();
}

void Worker::FinishTasks() {
    std::vector<Finish> due;
    {
        const std::scoped_lock lock(m_mutex);
        due.swap(m_due);
    }
    for (const Finish& finish : due) {
        --m_unfinished;
        finish();
    }
}

void Worker::Run() {
    std::unique_lock lock(m_mutex);
    while (true) {
        m_hasChanged.wait(lock, [&] { return m_isEnding || !m_tasks.empty(); });
        if (m_tasks.empty()) return;
        Entry entry = std::move(m_tasks.front());
        m_tasks.pop_front();
        lock.unlock();
        Finish finish;
        try {
            finish = entry.task();
        } catch (
            // Neither a task's Error nor an exception of a library ends the editor
            const std::exception& error) {
            finish = [fail = std::move(entry.fail), why = std::string(error.what())] { fail(why); };
        }
        entry = {};  // the task may hold much memory
        lock.lock();
        m_due.push_back(std::move(finish));
    }
}

}  // namespace raygraph::editor
