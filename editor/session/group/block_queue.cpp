#include "editor/session/group/block_queue.h"

#include <algorithm>

namespace raygraph::session {

BlockQueue::BlockQueue(uint32_t deviceCount) : m_devices(deviceCount) {}

std::optional<SampleRange> BlockQueue::Next(uint32_t device, double samplesPerSecond) {
    std::unique_lock lock(m_mutex);
    Device& its = m_devices.at(device);
    if (m_isClosed) {
        its.state = State::Over;
        m_hasRequest.notify_all();
        return std::nullopt;
    }
    its.state = State::Asking;
    m_requests.push_back({device, samplesPerSecond});
    m_hasRequest.notify_all();
    m_hasAnswer.wait(lock, [&] { return its.state != State::Asking; });
    return its.answer;
}

void BlockQueue::Fail(uint32_t device, std::exception_ptr error) {
    const std::scoped_lock lock(m_mutex);
    m_devices.at(device).state = State::Over;
    if (!m_error) m_error = std::move(error);
    m_hasRequest.notify_all();
}

std::optional<BlockQueue::Request> BlockQueue::TakeRequest(std::chrono::microseconds patience) {
    std::unique_lock lock(m_mutex);
    const auto isOver = [&] {
        return std::ranges::all_of(m_devices, [](const Device& d) { return d.state == State::Over; });
    };
    m_hasRequest.wait_for(lock, patience, [&] { return !m_requests.empty() || isOver(); });
    if (m_requests.empty()) return std::nullopt;
    const Request request = m_requests.front();
    m_requests.pop_front();
    return request;
}

void BlockQueue::Answer(uint32_t device, const std::optional<SampleRange>& block) {
    const std::scoped_lock lock(m_mutex);
    Device& its = m_devices.at(device);
    its.answer = block;
    its.state = block ? State::Answered : State::Over;
    m_hasAnswer.notify_all();
}

void BlockQueue::Close() {
    const std::scoped_lock lock(m_mutex);
    m_isClosed = true;
    m_requests.clear();
    for (Device& device : m_devices) {
        if (device.state != State::Asking) continue;
        device.answer.reset();
        device.state = State::Over;
    }
    m_hasAnswer.notify_all();
}

bool BlockQueue::IsOver() const {
    const std::scoped_lock lock(m_mutex);
    return std::ranges::all_of(m_devices, [](const Device& d) { return d.state == State::Over; });
}

bool BlockQueue::HasFailed() const {
    const std::scoped_lock lock(m_mutex);
    return m_error != nullptr;
}

void BlockQueue::RethrowError() const {
    std::exception_ptr error;
    {
        const std::scoped_lock lock(m_mutex);
        error = m_error;
    }
    if (error) std::rethrow_exception(error);
}

}  // namespace raygraph::session
