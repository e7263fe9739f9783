#include "base/os/signals.h"

#include <atomic>
#include <csignal>

namespace raygraph::os {

namespace {

// Lock-free, so allowed in a signal handler; Mesa's worker threads may be the ones that run it.
std::atomic<bool> isInterrupted{false}, isTerminated{false}, isSaveRequested{false}, isNoting{false};
std::atomic<void (*)()> endAtOnceIfAsked{nullptr};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<void (*)()>::is_always_lock_free);

void NoteInterrupt(int) {
    isInterrupted.store(true, std::memory_order_relaxed);
}

void NoteTermination(int) {
    if (!isNoting.load(std::memory_order_relaxed)) endAtOnceIfAsked.load(std::memory_order_relaxed)();
    isTerminated.store(true, std::memory_order_relaxed);
}

void NoteSave(int) {
    isSaveRequested.store(true, std::memory_order_relaxed);
}

// `flags` beside SA_RESTART.
void Handle(int signal, void (*handler)(int), int flags, struct sigaction* before) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = flags | SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaction(signal, &action, before);
}

}  // namespace

struct SignalWatch::Before {
    struct sigaction interrupt {
    }, terminate{}, user1{}, user2{};
    bool isNotingInterrupts = false;
};

SignalWatch::SignalWatch(void (*endAtOnce)()) : m_before(std::make_unique<Before>()) {
    isInterrupted = isTerminated = isSaveRequested = isNoting = false;
    endAtOnceIfAsked = endAtOnce;
    Handle(SIGTERM, NoteTermination, 0, &m_before->terminate);
    Handle(SIGUSR1, NoteSave, 0, &m_before->user1);
    Handle(SIGUSR2, NoteTermination, 0, &m_before->user2);
}

void SignalWatch::StartNoting() {
    isNoting = true;
    if (m_before->isNotingInterrupts) return;
    m_before->isNotingInterrupts = true;
    Handle(SIGINT, NoteInterrupt, static_cast<int>(SA_RESETHAND), &m_before->interrupt);
}

SignalWatch::~SignalWatch() {
    if (m_before->isNotingInterrupts) sigaction(SIGINT, &m_before->interrupt, nullptr);
    sigaction(SIGTERM, &m_before->terminate, nullptr);
    sigaction(SIGUSR1, &m_before->user1, nullptr);
    sigaction(SIGUSR2, &m_before->user2, nullptr);
}

bool SignalWatch::IsInterrupted() const {
    return isInterrupted.load(std::memory_order_relaxed);
}

bool SignalWatch::IsTerminated() const {
    return isTerminated.load(std::memory_order_relaxed);
}

bool SignalWatch::IsSaveRequested() const {
    return isSaveRequested.load(std::memory_order_relaxed);
}

void SignalWatch::ForgetSave() {
    isSaveRequested.store(false, std::memory_order_relaxed);
}

}  // namespace raygraph::os
