// Ctrl-C during a render: noticed, not obeyed at once, so that the render can write what it has.
#pragma once

#include <csignal>

namespace raygraph::cli {

// While it lives, the first SIGINT or SIGTERM is noted; a second one ends the process as usual. One at a
// time.
class InterruptWatch {
  public:
    InterruptWatch();
    ~InterruptWatch();
    InterruptWatch(const InterruptWatch&) = delete;
    InterruptWatch& operator=(const InterruptWatch&) = delete;

    bool IsRequested() const;

  private:
    struct sigaction m_oldInterrupt {};
    struct sigaction m_oldTerminate {};
};

}  // namespace raygraph::cli
