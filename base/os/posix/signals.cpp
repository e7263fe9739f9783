#include "base/os/signals.h"

#include <array>
#include <atomic>
#include <csignal>
#include <utility>
#include <vector>

namespace raygraph::os {

namespace {

// Lock-free, so allowed in a signal handler; Mesa's worker threads may be the ones that run it.
std::atomic<bool> isInterrupted{false}, isTerminated{false}, isSaveRequested{false}, isNoting{false};
std::atomic<void (*)()> endAtOnceIfAsked{nullptr};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<void (*)()>::is_always_lock_free);

constexpr std::array kSignalsToEnd{SIGTERM, SIGUSR2, SIGHUP, SIGXCPU};

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

}  // namespace

struct SignalWatch::Before {
    // `flags` beside SA_RESTART.
    void Handle(int signal, void (*handler)(int), int flags = 0) {
        struct sigaction before {
        }, action{};
        sigaction(signal, nullptr, &before);
        if (before.sa_handler == SIG_IGN) return;
        action.sa_handler = handler;
        action.sa_flags = flags | SA_RESTART;
        sigemptyset(&action.sa_mask);
        sigaction(signal, &action, nullptr);
        handled.emplace_back(signal, before);
    }

    std::vector<std::pair<int, struct sigaction>> handled;
    bool isNotingInterrupts = false;
};

SignalWatch::SignalWatch(void (*endAtOnce)()) : m_before(std::make_unique<Before>()) {
    isInterrupted = isTerminated = isSaveRequested = isNoting = false;
    endAtOnceIfAsked = endAtOnce;
    for (const int signal : kSignalsToEnd) m_before->Handle(signal, NoteTermination);
    m_before->Handle(SIGUSR1, NoteSave);
}

void SignalWatch::StartNoting() {
    isNoting = true;
    if (std::exchange(m_before->isNotingInterrupts, true)) return;
    m_before->Handle(SIGINT, NoteInterrupt, static_cast<int>(SA_RESETHAND));
}

SignalWatch::~SignalWatch() {
    for (const auto& [signal, before] : m_before->handled) sigaction(signal, &before, nullptr);
    isInterrupted = isTerminated = false;
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

bool IsAskedToEnd() {
    return isInterrupted.load(std::memory_order_relaxed) || isTerminated.load(std::memory_order_relaxed);
}

}  // namespace raygraph::os
