// Signals that ask a program to save its work, or to end. Threads: any, but see SignalWatch.
#pragma once

#include <memory>

namespace raygraph::os {

// Notes signals instead of letting them end the process at once, so that a render can write its samples:
// SIGINT (Ctrl-C); to end, SIGTERM, SIGUSR2, by which clusters say that a job is about to be ended, SIGHUP of
// a closed terminal and SIGXCPU of a limit on processor time; SIGUSR1, by which clusters ask it to save. A
// second SIGINT ends the process as usual. One that the process was started to ignore, as by nohup or in the
// background of a script, stays ignored. One object at a time.
class SignalWatch {
  public:
    // Until StartNoting there is nothing to save: SIGINT ends the process as usual, the signals to end call
    // `endAtOnce` in their handler. SIGUSR1 is noted from the start.
    explicit SignalWatch(void (*endAtOnce)());
    ~SignalWatch();
    SignalWatch(const SignalWatch&) = delete;
    SignalWatch& operator=(const SignalWatch&) = delete;

    void StartNoting();

    bool IsInterrupted() const;    // by SIGINT
    bool IsTerminated() const;     // by one of the signals to end
    bool IsSaveRequested() const;  // by SIGUSR1, since the last ForgetSave
    void ForgetSave();

  private:
    struct Before;
    std::unique_ptr<Before> m_before;
};

// Returns whether the SignalWatch, if there is one, has noted SIGINT or a signal to end.
bool IsAskedToEnd();

}  // namespace raygraph::os
