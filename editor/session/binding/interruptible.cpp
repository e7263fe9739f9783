#include "editor/session/binding/interruptible.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace raygraph::session {

struct Caller::State {
    std::mutex lock;
    std::condition_variable changed;
    const std::function<void()>* question = nullptr;  // to be run by the caller
    bool isStopRequested = false, isDone = false;
    bool isStopped = false;  // it has ended by ThrowIfStopRequested
    std::exception_ptr failure;
};

namespace {

struct Stopped {};

// The threads that were left behind. It lives as long as the process: they may end after its statics.
struct AbandonedThreads {
    struct Entry {
        std::shared_ptr<Caller::State> state;
        std::thread thread;
    };
    std::mutex joining;  // taken first: whoever waits while another one does waits for the same threads
    std::mutex lock;
    std::vector<Entry> entries;
};
AbandonedThreads& Abandoned() {
    static AbandonedThreads& abandoned = *new AbandonedThreads;
    return abandoned;
}

// Leaves a thread behind, and joins those that have ended since, whose stacks are kept until then.
void Abandon(const std::shared_ptr<Caller::State>& state, std::thread thread) {
    AbandonedThreads& all = Abandoned();
    const std::scoped_lock lock(all.lock);
    std::erase_if(all.entries, [](AbandonedThreads::Entry& entry) {
        {
            const std::scoped_lock reading(entry.state->lock);
            if (!entry.state->isDone) return false;
        }
        entry.thread.join();
        return true;
    });
    all.entries.push_back({state, std::move(thread)});
}

void Work(const std::shared_ptr<Caller::State>& state, std::function<void(Caller&)> work) {
    bool isStopped = false;
    std::exception_ptr failure;
    try {
        Caller caller(*state);
        work(caller);
    } catch (const Stopped&) {
        isStopped = true;
    } catch (...) {
        failure = std::current_exception();
    }
    work = {};  // frees what it owns
    const std::scoped_lock lock(state->lock);
    state->isDone = true;
    state->isStopped = isStopped;
    state->failure = std::exchange(failure, nullptr);
    state->changed.notify_all();
}

}  // namespace

bool Caller::IsStopRequested() const {
    const std::scoped_lock lock(m_state.lock);
    return m_state.isStopRequested;
}

void Caller::ThrowIfStopRequested() const {
    if (IsStopRequested()) throw Stopped{};
}

void Caller::Ask(const std::function<void()>& question) {
    std::unique_lock lock(m_state.lock);
    if (m_state.isStopRequested) return;
    m_state.question = &question;
    m_state.changed.notify_all();
    m_state.changed.wait(lock, [&] { return m_state.question == nullptr; });
}

bool detail::RunOnThread(std::function<void(Caller&)> work, const std::function<bool()>& isStopRequested) {
    constexpr auto kInterval = std::chrono::milliseconds(20);
    constexpr auto kGrace = std::chrono::milliseconds(200);
    const auto state = std::make_shared<Caller::State>();
    std::thread thread(Work, state, std::move(work));
    std::unique_lock lock(state->lock);
    const auto needsCaller = [&] { return state->isDone || state->question != nullptr; };
    while (!state->isDone) {
        const bool isAsked = state->changed.wait_for(lock, kInterval, needsCaller);
        if (state->isDone) break;
        // The work waits for the answer, or does not look at it: neither needs the lock meanwhile
        const std::function<void()>* const question = state->question;
        lock.unlock();
        if (isAsked) (*question)();
        const bool isStopped = isStopRequested();
        lock.lock();
        if (isAsked) {
            state->question = nullptr;
            state->changed.notify_all();
        }
        if (!isStopped) continue;
        state->isStopRequested = true;
        // A question that came meanwhile gets no answer
        state->question = nullptr;
        state->changed.notify_all();
        if (state->changed.wait_for(lock, kGrace, [&] { return state->isDone; })) break;
        lock.unlock();
        Abandon(state, std::move(thread));
        return false;
    }
    lock.unlock();
    thread.join();
    if (state->failure) std::rethrow_exception(state->failure);
    return !state->isStopped;
}

void WaitForAbandonedWork() {
    AbandonedThreads& all = Abandoned();
    const std::scoped_lock joining(all.joining);
    std::vector<AbandonedThreads::Entry> entries;
    {
        const std::scoped_lock lock(all.lock);
        entries.swap(all.entries);
    }
    for (AbandonedThreads::Entry& entry : entries) entry.thread.join();
}

}  // namespace raygraph::session
