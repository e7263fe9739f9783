// FrameTimer: GPU times of the passes of each frame, combined with the CPU's when they arrive. Threads: that
// of the Renderer.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "renderer/graph/renderer.h"
#include "rhi/timestamps.h"

namespace raygraph {

class FrameTimer {
  public:
    // Without `gpuTimes`, or on a device without timestamps, the GPU times are 0.
    FrameTimer(rhi::Device& device, bool gpuTimes);

    void BeginFrame(rhi::CommandList& commands);
    // Must be called once before the first pass, and once after each pass.
    void Stamp(rhi::CommandList& commands);
    void EndFrame(uint64_t submitted, FrameTiming timing);

    // Takes the results that have arrived, without waiting.
    void Poll();
    const FrameTiming& Latest() const { return m_latest; }
    std::vector<FrameTiming> TakeAll();

  private:
    struct Pending {
        uint64_t submitted = 0;
        FrameTiming timing;
    };
    void StoreTiming(FrameTiming timing);

    rhi::Device& m_device;
    std::unique_ptr<rhi::TimestampPool> m_timestamps;
    std::deque<Pending> m_pending;
    std::deque<FrameTiming> m_arrived;
    FrameTiming m_latest;
};

}  // namespace raygraph
