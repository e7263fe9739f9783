// RetireQueue: objects to be destroyed once the device cannot use them any more. Uses only numbers,
// no Vulkan.
//
// Two clocks decide. Timeline values give the progress of the device. Serials identify the command lists that
// were being recorded when the object was retired: such a list may still refer to it, so the object waits
// until each of them has been submitted (and then for that submission) or dropped.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <set>
#include <vector>

namespace raygraph::rhi {

// Thread-safe. The functions run on the thread that calls Collect or Retire, outside the queue's lock; they
// may retire more.
class RetireQueue {
  public:
    using Destroy = std::function<void()>;

    // A command list starts to be recorded; serials increase.
    uint64_t OpenList();
    // It was submitted as this timeline value, or dropped (0).
    void CloseList(uint64_t serial, uint64_t submittedValue);

    // Runs `destroy` at once when nothing can be using the object any more, otherwise keeps it.
    void Retire(Destroy destroy, uint64_t completed);
    // Runs the functions of objects that the timeline has passed.
    void Collect(uint64_t completed);
    // Runs all functions, in order: for a device that is idle or lost.
    void CollectAll();
    // The number of objects that are waiting.
    size_t PendingCount() const;

  private:
    struct Entry {
        uint64_t until = 0;  // m_recorded: the last serial open at that time; m_submitted: a timeline value
        Destroy destroy;
    };
    void MoveRecorded();

    mutable std::mutex m_mutex;
    uint64_t m_lastSerial = 0;
    uint64_t m_lastSubmitted = 0;
    std::set<uint64_t> m_open;
    std::deque<Entry> m_recorded;   // waiting for lists to be closed
    std::deque<Entry> m_submitted;  // waiting for the timeline
};

}  // namespace raygraph::rhi
