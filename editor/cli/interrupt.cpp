#include "editor/cli/interrupt.h"

#include <atomic>

namespace raygraph::cli {

namespace {

// Lock-free, so allowed in a signal handler; Mesa's worker threads may be the ones that run it.
std::atomic<bool> isInterrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void Note(int) {
    isInterrupted.store(true, std::memory_order_relaxed);
}

}  // namespace

InterruptWatch::InterruptWatch() {
    isInterrupted = false;
    struct sigaction action {};
    action.sa_handler = Note;
    action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, &m_oldInterrupt);
    sigaction(SIGTERM, &action, &m_oldTerminate);
}

InterruptWatch::~InterruptWatch() {
    sigaction(SIGINT, &m_oldInterrupt, nullptr);
    sigaction(SIGTERM, &m_oldTerminate, nullptr);
}

bool InterruptWatch::IsRequested() const {
    return isInterrupted.load(std::memory_order_relaxed);
}

}  // namespace raygraph::cli
