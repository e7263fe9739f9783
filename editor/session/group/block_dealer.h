// BlockDealer deals the samples of a picture to workers so that all are busy to the end. Threads: one at a
// time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

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

}  // namespace raygraph::session
