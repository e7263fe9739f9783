// Deals the samples of a picture to those who render them, so that all are busy to the end. Threads: one
// at a time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "base/api.h"
#include "editor/session/sample_ranges.h"

namespace raygraph::session {

// One device that renders samples: of which process, and which of its devices.
struct BlockWorker {
    uint32_t process = 0, device = 0;
    auto operator<=>(const BlockWorker&) const = default;
};

// From where a worker gets its samples.
class RAYGRAPH_API BlockSource {
  public:
    virtual ~BlockSource() = default;
    // The next block for a device of this process, which has rendered its last one, or submitted it; none:
    // there are no more. `samplesPerSecond`: how fast it is; 0: not known yet. May wait.
    virtual std::optional<SampleRange> Next(uint32_t device, double samplesPerSecond) = 0;
};

// Blocks are aligned: their size is a power of two, and their first index a multiple of it. A block takes its
// worker about `blockSeconds` by the speed that was measured, and less towards the end: half of its share of
// what is left; but it has `leastCount` samples, which a device renders at once, where there are as many and
// its worker does them in that time. Where there is one worker, a block is no larger. A worker's first block
// is one sample. Blocks are dealt in order.
class RAYGRAPH_API BlockDealer : public BlockSource {
  public:
    // `workerCount`: of those who will ask, at least 1. `samples` are not empty. `leastCount` is a power of
    // two.
    BlockDealer(SampleRange samples, uint32_t workerCount, double blockSeconds, uint32_t leastCount = 1);

    std::optional<SampleRange> Next(uint32_t device, double samplesPerSecond) override {
        return Next(BlockWorker{0, device}, samplesPerSecond);
    }
    std::optional<SampleRange> Next(BlockWorker worker, double samplesPerSecond);
    // Deals no more, but for the very first block.
    void Stop();

    // Samples that were dealt, all from the first one on; and those of them that are done, as far as is
    // known.
    uint32_t DealtCount() const;
    uint32_t DoneCount() const;

  private:
    struct Worker {
        double samplesPerSecond = 0.0;
        uint32_t pending = 0;  // samples of its block
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
