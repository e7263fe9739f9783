// FrameTimer: GPU times of the passes of each frame, combined with the CPU's when they arrive. Threads: that
// of the Renderer.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "renderer/graph/renderer.h"
#include "rhi/timestamps.h"

namespace raygraph {

class FrameTimer {
  public:
    // Without `gpuTimes`, or on a device without timestamps, the GPU times are 0. The newest `kept` frames
    // wait for TakeAll.
    FrameTimer(rhi::Device& device, bool gpuTimes, size_t kept);

    // Returns an object for EndFrame, with the passes of any earlier frame, to use their memory again.
    FrameTiming NewTiming();

    void BeginFrame(rhi::CommandList& commands);
    // Must be called after each pass.
    void Stamp(rhi::CommandList& commands);
    // Must be called at the beginning of each further submission of the frame, before the pass of this index.
    void BeginBatch(rhi::CommandList& commands, uint32_t firstPass);
    void EndFrame(uint64_t submitted, FrameTiming timing);

    // Takes the results that have arrived, without waiting.
    void Poll();
    const FrameTiming& Latest() const { return m_latest; }
    std::vector<FrameTiming> TakeAll();

  private:
    struct Pending {
        uint64_t submitted = 0;
        FrameTiming timing;
        std::vector<uint32_t> batches;  // first pass of each further submission
    };
    void StoreTiming(FrameTiming timing);
    FrameTiming TakePending();

    rhi::Device& m_device;
    size_t m_kept;
    std::unique_ptr<rhi::TimestampPool> m_timestamps;
    std::vector<Pending> m_pending;  // oldest first; they are few
    // A ring once it is full: the oldest is at m_oldest.
    std::vector<FrameTiming> m_arrived;
    size_t m_oldest = 0;
    FrameTiming m_latest;
    std::vector<FrameTiming> m_unused;
    std::vector<uint32_t> m_batches;  // as Pending::batches, of the frame that is recorded
};

}  // namespace raygraph
