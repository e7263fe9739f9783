#include "rhi/retire_queue.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace raygraph::rhi {
namespace {

bool HasPassed(const QueueValues& completed, const QueueValues& until) {
    return std::ranges::equal(until, completed, std::ranges::less_equal());
}

}  // namespace

uint64_t RetireQueue::OpenList() {
    const std::lock_guard lock(m_mutex);
    m_open.push_back(++m_lastSerial);
    return m_lastSerial;
}

void RetireQueue::CloseList(uint64_t serial, const Submission& submission) {
    const std::lock_guard lock(m_mutex);
    std::erase(m_open, serial);
    uint64_t& last = m_lastSubmitted[IndexOf(submission.queue)];
    last = std::max(last, submission.value);
    MoveRecorded();
}

// Entries whose lists are all closed wait for the newest submissions, which are not older than any of those
// lists.
void RetireQueue::MoveRecorded() {
    const uint64_t oldestOpen = m_open.empty() ? std::numeric_limits<uint64_t>::max() : m_open.front();
    while (!m_recorded.empty() && m_recorded.front().lastSerial < oldestOpen) {
        m_submitted.push_back({m_lastSubmitted, std::move(m_recorded.front().destroy)});
        m_recorded.pop_front();
    }
}

void RetireQueue::Retire(Destroy destroy, const QueueValues& completed) {
    {
        const std::lock_guard lock(m_mutex);
        if (!m_open.empty()) {
            m_recorded.push_back({m_lastSerial, std::move(destroy)});
            return;
        }
        // The object must not be destroyed before those retired earlier, even if the timelines have passed
        // both.
        if (!HasPassed(completed, m_lastSubmitted) || !m_submitted.empty()) {
            m_submitted.push_back({m_lastSubmitted, std::move(destroy)});
            return;
        }
    }
    destroy();
}

void RetireQueue::Collect(const QueueValues& completed) {
    std::vector<Destroy> due;
    {
        const std::lock_guard lock(m_mutex);
        while (!m_submitted.empty() && HasPassed(completed, m_submitted.front().until)) {
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
        QueueValues all;
        all.fill(std::numeric_limits<uint64_t>::max());
        Collect(all);
    }
}

size_t RetireQueue::PendingCount() const {
    const std::lock_guard lock(m_mutex);
    return m_recorded.size() + m_submitted.size();
}

}  // namespace raygraph::rhi
