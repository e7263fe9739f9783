// Where the devices of one process wait for samples, each on a thread of its own, and one thread answers
// them. Threads: any, but see BlockQueue.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <vector>

#include "editor/session/block_dealer.h"

namespace raygraph::session {

// Threads: any; Next is for the devices' threads, the rest for the one that answers.
class RAYGRAPH_API BlockQueue : public BlockSource {
  public:
    explicit BlockQueue(uint32_t deviceCount);
    uint32_t DeviceCount() const { return static_cast<uint32_t>(m_devices.size()); }

    // Waits for the answer.
    std::optional<SampleRange> Next(uint32_t device, double samplesPerSecond) override;
    // A device's thread ends with an error: the device asks for no more.
    void Fail(uint32_t device, std::exception_ptr error);

    struct Request {
        uint32_t device = 0;
        double samplesPerSecond = 0.0;
    };
    // The next request, at most one a device; none if there is none for so long.
    std::optional<Request> TakeRequest(std::chrono::microseconds patience);
    // None: the device gets no more.
    void Answer(uint32_t device, const std::optional<SampleRange>& block);
    // Answers all requests, and all that come, with none.
    void Close();
    // All devices have got none, or have failed.
    bool IsOver() const;
    bool HasFailed() const;
    // Throws the error of a device that has failed, if there is one.
    void RethrowError() const;

  private:
    enum class State : uint8_t { Working, Asking, Answered, Over };
    struct Device {
        State state = State::Working;
        std::optional<SampleRange> answer;
    };

    mutable std::mutex m_mutex;  // of all that follows
    std::condition_variable m_hasRequest, m_hasAnswer;
    std::vector<Device> m_devices;
    std::deque<Request> m_requests;
    std::exception_ptr m_error;  // the first
    bool m_isClosed = false;
};

}  // namespace raygraph::session
