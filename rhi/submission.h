// Submission: names work that was given to a queue of a device. Threads: plain values, for any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace raygraph::rhi {

// The queues of a device. Every device has the main one; the others are queues of other families, which
// execute beside it where a device has them.
enum class QueueKind : uint8_t {
    Main,      // graphics, compute and transfer; presents
    Compute,   // compute and transfer: passes that may run beside others
    Transfer,  // copies: uploads that arrive while a frame is rendered
};
inline constexpr std::array kQueueKinds{QueueKind::Main, QueueKind::Compute, QueueKind::Transfer};

// Holds a value of each queue's timeline.
using QueueValues = std::array<uint64_t, kQueueKinds.size()>;
constexpr size_t IndexOf(QueueKind queue) {
    return static_cast<size_t>(queue);
}

// A point on the timeline of one queue of the Device that returned it. Values of different queues cannot be
// compared.
struct Submission {
    uint64_t value = 0;  // 0: no work, which counts as completed
    QueueKind queue = QueueKind::Main;

    explicit operator bool() const { return value != 0; }
    bool operator==(const Submission&) const = default;
};

}  // namespace raygraph::rhi
