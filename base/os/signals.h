// Signals that ask a program to save its work, or to end. Threads: any, but see SignalWatch.
#pragma once

#include <memory>

namespace raygraph::os {

// Notes signals instead of letting them end the process at once, so that a render can write its samples:
// SIGINT (Ctrl-C), SIGTERM and SIGUSR2, by which clusters say that a job is about to be ended, and SIGUSR1,
// by which they ask it to save. A second SIGINT ends the process as usual. One object at a time.
class SignalWatch {
  public:
    // Until StartNoting there is nothing to save: SIGINT ends the process as usual, SIGTERM and SIGUSR2 end
    // it at once with `terminatedStatus`. SIGUSR1 is noted from the start.
    explicit SignalWatch(int terminatedStatus);
    ~SignalWatch();
    SignalWatch(const SignalWatch&) = delete;
    SignalWatch& operator=(const SignalWatch&) = delete;

    void StartNoting();

    bool IsInterrupted() const;    // by SIGINT
    bool IsTerminated() const;     // by SIGTERM or SIGUSR2
    bool IsSaveRequested() const;  // by SIGUSR1, since the last ForgetSave
    void ForgetSave();

  private:
    struct Before;
    std::unique_ptr<Before> m_before;
};

}  // namespace raygraph::os
