// The blocks of samples that the devices of a process, or of several, render: BlockDealer deals them, and
// BlockQueue lets each device wait for its next one on a thread of its own, while one thread answers them
// all. Threads: BlockDealer: one at a time; BlockQueue: any, but see there.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "base/api.h"
#include "editor/session/file/sample_ranges.h"

namespace raygraph::session {

// Identifies a device that renders samples, by its process and its index there.
struct BlockWorker {
    uint32_t process = 0, device = 0;
    auto operator<=>(const BlockWorker&) const = default;
};

// Provides a worker with its samples.
class RAYGRAPH_API BlockSource {
  public:
    virtual ~BlockSource() = default;
    // Returns the next block for a device of this process that has rendered, or submitted, its last one; none
    // if no more are left. `samplesPerSecond` is its measured speed; 0: unknown. May wait.
    virtual std::optional<SampleRange> Next(uint32_t device, double samplesPerSecond) = 0;
};

// BlockDealer deals the samples of a picture to workers so that all are busy to the end.
//
// Blocks are aligned: their size is a power of two, and their first index is a multiple of it. A block takes
// its worker about `blockSeconds` by its measured speed, and towards the end only half of its share of the
// rest; but it has `leastCount` samples, which a device renders at once, if so many are left and its worker
// renders them in that time. With a single worker, a block is no larger. A worker's first block is one
// sample. Blocks are dealt in order.
class RAYGRAPH_API BlockDealer : public BlockSource {
  public:
    // `workerCount` is at least 1. `samples` must not be empty. `leastCount` is a power of two.
    BlockDealer(SampleRange samples, uint32_t workerCount, double blockSeconds, uint32_t leastCount = 1);

    std::optional<SampleRange> Next(uint32_t device, double samplesPerSecond) override {
        return Next(BlockWorker{0, device}, samplesPerSecond);
    }
    std::optional<SampleRange> Next(BlockWorker worker, double samplesPerSecond);
    // Deals no more blocks, except for the very first.
    void Stop();

    // Return the dealt samples, which are consecutive from the first one, and how many of them are known to
    // be done.
    uint32_t DealtCount() const;
    uint32_t DoneCount() const;

  private:
    struct Worker {
        double samplesPerSecond = 0.0;
        uint32_t pending = 0;  // samples of its current block
    };
    uint32_t BlockSize(double samplesPerSecond) const;

    SampleRange m_samples;
    uint32_t m_workerCount;
    double m_blockSeconds;
    uint32_t m_leastCount;
    uint32_t m_dealt = 0;
    bool m_isStopped = false;
    std::map<BlockWorker, Worker> m_workers;
};

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
