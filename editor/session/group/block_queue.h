// BlockQueue lets each device of a process wait for samples on a thread of its own, while one thread answers
// them. Threads: any, but see BlockQueue.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <vector>

#include "editor/session/group/block_dealer.h"

namespace raygraph::session {

// Threads: any; Next is for the devices' threads, the rest for the answering thread.
class RAYGRAPH_API BlockQueue : public BlockSource {
  public:
    explicit BlockQueue(uint32_t deviceCount);
    uint32_t DeviceCount() const { return static_cast<uint32_t>(m_devices.size()); }

    // Waits for the answer.
    std::optional<SampleRange> Next(uint32_t device, double samplesPerSecond) override;
    // Records the error with which a device's thread ends; the device asks for no more.
    void Fail(uint32_t device, std::exception_ptr error);

    struct Request {
        uint32_t device = 0;
        double samplesPerSecond = 0.0;
    };
    // Returns the next request, of which a device has at most one; none if none comes in this time.
    std::optional<Request> TakeRequest(std::chrono::microseconds patience);
    // Answers a device; none: it gets no more.
    void Answer(uint32_t device, const std::optional<SampleRange>& block);
    // Answers all present and future requests with none.
    void Close();
    // Returns whether every device has got none, or has failed.
    bool IsOver() const;
    bool HasFailed() const;
    // Throws the error of a failed device, if there is one.
    void RethrowError() const;

  private:
    enum class State : uint8_t { Working, Asking, Answered, Over };
    struct Device {
        State state = State::Working;
        std::optional<SampleRange> answer;
    };

    mutable std::mutex m_mutex;  // guards all members below
    std::condition_variable m_hasRequest, m_hasAnswer;
    std::vector<Device> m_devices;
    std::deque<Request> m_requests;
    std::exception_ptr m_error;  // first error
    bool m_isClosed = false;
};

}  // namespace raygraph::session
