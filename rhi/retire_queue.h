// RetireQueue: destroys objects once the device cannot use them any more. It uses numbers, and no Vulkan.
//
// Two clocks decide. Values of the queues' timelines give the progress of the device. Serials identify the
// command lists that were being recorded when the object was retired: such a list may still refer to it, so
// the object waits until each of them has been submitted (and then for that submission) or dropped.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <vector>

#include "rhi/submission.h"

namespace raygraph::rhi {

// The functions run on the thread that calls Collect or Retire, outside of the queue's lock; they may retire
// more objects. Threads: any.
class RetireQueue {
  public:
    using Destroy = std::function<void()>;

    // Starts the recording of a command list, and returns its serial; serials increase.
    uint64_t OpenList();
    // The list was submitted, or dropped (value 0).
    void CloseList(uint64_t serial, const Submission& submission);

    // Calls `destroy` at once if nothing can use the object any more, otherwise keeps it.
    void Retire(Destroy destroy, const QueueValues& completed);
    // Calls the functions of objects that the timelines have passed.
    void Collect(const QueueValues& completed);
    // Calls all functions, in order, for a device that is idle or lost.
    void CollectAll();
    // Returns the number of objects that are waiting.
    size_t PendingCount() const;

  private:
    struct Recorded {
        uint64_t lastSerial = 0;  // of the lists open at that time
        Destroy destroy;
    };
    struct Submitted {
        QueueValues until{};
        Destroy destroy;
    };
    void MoveRecorded();

    mutable std::mutex m_mutex;
    uint64_t m_lastSerial = 0;
    QueueValues m_lastSubmitted{};
    std::vector<uint64_t> m_open;       // in ascending order
    std::deque<Recorded> m_recorded;    // waiting for lists to be closed
    std::deque<Submitted> m_submitted;  // waiting for the timelines
};

}  // namespace raygraph::rhi
