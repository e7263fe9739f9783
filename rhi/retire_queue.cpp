#include "rhi/retire_queue.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace raygraph::rhi {

uint64_t RetireQueue::OpenList() {
    const std::lock_guard lock(m_mutex);
    m_open.insert(++m_lastSerial);
    return m_lastSerial;
}

void RetireQueue::CloseList(uint64_t serial, uint64_t submittedValue) {
    const std::lock_guard lock(m_mutex);
    m_open.erase(serial);
    m_lastSubmitted = std::max(m_lastSubmitted, submittedValue);
    MoveRecorded();
}

// Entries whose lists are all closed wait for the newest submission, which is not older than any of those
// lists.
void RetireQueue::MoveRecorded() {
    const uint64_t oldestOpen = m_open.empty() ? std::numeric_limits<uint64_t>::max() : *m_open.begin();
    while (!m_recorded.empty() && m_recorded.front().until < oldestOpen) {
        m_submitted.push_back({m_lastSubmitted, std::move(m_recorded.front().destroy)});
        m_recorded.pop_front();
    }
}

void RetireQueue::Retire(Destroy destroy, uint64_t completed) {
    {
        const std::lock_guard lock(m_mutex);
        if (!m_open.empty()) {
            m_recorded.push_back({m_lastSerial, std::move(destroy)});
            return;
        }
        // The object must not be destroyed before those retired earlier, even if the timeline has passed
        // both.
        if (m_lastSubmitted > completed || !m_submitted.empty()) {
            m_submitted.push_back({m_lastSubmitted, std::move(destroy)});
            return;
        }
    }
    destroy();
}

void RetireQueue::Collect(uint64_t completed) {
    std::vector<Destroy> due;
    {
        const std::lock_guard lock(m_mutex);
        while (!m_submitted.empty() && m_submitted.front().until <= completed) {
            due.push_back(std::move(m_submitted.front().destroy));
            m_submitted.pop_front();
        }
    }
    for (const Destroy& destroy : due) destroy();
}

void RetireQueue::CollectAll() {
    while (PendingCount() > 0) {
        {
            const std::lock_guard lock(m_mutex);
            m_open.clear();
            MoveRecorded();
        }
        Collect(std::numeric_limits<uint64_t>::max());
    }
}

size_t RetireQueue::PendingCount() const {
    const std::lock_guard lock(m_mutex);
    return m_recorded.size() + m_submitted.size();
}

}  // namespace raygraph::rhi
