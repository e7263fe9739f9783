#include "editor/session/group/block_queue.h"

#include <algorithm>
#include <bit>

#include "base/check.h"

namespace raygraph::session {

BlockQueue::BlockQueue(uint32_t deviceCount) : m_devices(deviceCount) {}

std::optional<SampleRange> BlockQueue::Next(uint32_t device, double samplesPerSecond) {
    std::unique_lock lock(m_mutex);
    Device& entry = m_devices.at(device);
    if (m_isClosed) {
        entry.state = State::Over;
        m_hasRequest.notify_all();
        return std::nullopt;
    }
    entry.state = State::Asking;
    m_requests.push_back({device, samplesPerSecond});
    m_hasRequest.notify_all();
    m_hasAnswer.wait(lock, [&] { return entry.state != State::Asking; });
    return entry.answer;
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
    Device& entry = m_devices.at(device);
    entry.answer = block;
    entry.state = block ? State::Answered : State::Over;
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

BlockDealer::BlockDealer(SampleRange samples, uint32_t workerCount, double blockSeconds, uint32_t leastCount)
    : m_samples(samples), m_workerCount(workerCount), m_blockSeconds(blockSeconds), m_leastCount(leastCount) {
    RG_CHECK(samples.count > 0 && workerCount > 0 && std::has_single_bit(leastCount));
}

// A worker that was not measured yet gets one sample. A measured one gets as many as a device renders at
// once, if those take no longer than a block, because a block cannot end early.
uint32_t BlockDealer::BlockSize(double samplesPerSecond) const {
    if (samplesPerSecond <= 0.0) return 1;
    const uint32_t inTime = std::bit_floor(
        static_cast<uint32_t>(std::clamp(samplesPerSecond * m_blockSeconds, 1.0, 2147483648.0)));
    const uint32_t least = std::min(m_leastCount, inTime);
    if (m_workerCount == 1) return least;
    double ofAll = 0.0;
    uint32_t measured = 0;
    for (const auto& [id, worker] : m_workers) {
        ofAll += worker.samplesPerSecond;
        measured += worker.samplesPerSecond > 0.0 ? 1 : 0;
    }
    // Workers that were not measured yet count as the average
    ofAll *= static_cast<double>(std::max(m_workerCount, measured)) / measured;
    const double left = m_samples.count - m_dealt;
    const double wanted = std::min(samplesPerSecond * m_blockSeconds, 0.5 * left * samplesPerSecond / ofAll);
    return std::bit_floor(static_cast<uint32_t>(std::clamp(wanted, 1.0 * least, 2147483648.0)));
}

std::optional<SampleRange> BlockDealer::Next(BlockWorker id, double samplesPerSecond) {
    Worker& worker = m_workers[id];
    worker = {samplesPerSecond, 0};
    const uint32_t left = m_samples.count - m_dealt;
    if (left == 0 || (m_isStopped && m_dealt > 0)) return std::nullopt;
    const uint32_t first = m_samples.first + m_dealt;
    const uint32_t alignment = first == 0 ? 0x80000000u : first & (~first + 1);
    const uint32_t count = std::min({BlockSize(samplesPerSecond), alignment, std::bit_floor(left)});
    worker.pending = count;
    m_dealt += count;
    return SampleRange{first, count};
}

void BlockDealer::Stop() {
    m_isStopped = true;
}

uint32_t BlockDealer::DealtCount() const {
    return m_dealt;
}

uint32_t BlockDealer::DoneCount() const {
    uint32_t pending = 0;
    for (const auto& [id, worker] : m_workers) pending += worker.pending;
    return m_dealt - pending;
}

}  // namespace raygraph::session
