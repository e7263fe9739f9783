// PassMarks: tells which pass the device had reached when it was lost.
//
// Before a pass runs, and once its waits are over, the device writes the frame's number into that pass's word
// of mapped memory. Every pass has one word for each frame in flight, so that no two writes conflict. A word
// with the number tells that everything for which the pass waited has completed. Threads: that of the
// Renderer, except for Report.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "rhi/command_list.h"
#include "rhi/device.h"

namespace raygraph {

class PassMarks {
  public:
    static constexpr uint32_t kMaxPasses = 256;  // later passes of a frame leave no mark

    explicit PassMarks(rhi::Device& device);

    // Starts the marks of a frame, whose memory is that of the frame framesInFlight before.
    void BeginFrame(uint64_t frame);
    // Marks the begin of the next pass. Must be recorded outside of rendering, after the pass's barriers,
    // which must make transfers wait, too.
    void Mark(rhi::CommandList& commands, const std::string& pass);
    // Returns the last mark of the newest frame that has one, `the last pass reached was pass "Trace" (2 of
    // 3) of frame 12`; empty if there is none. May be called from any thread.
    std::string Report() const;

  private:
    struct Frame {
        uint64_t number = 0;
        std::vector<std::string> passes;
    };
    uint64_t OffsetOf(size_t slot, size_t pass) const {
        return (slot * kMaxPasses + pass) * sizeof(uint32_t);
    }
    static uint32_t ValueOf(uint64_t frame) {
        return static_cast<uint32_t>(frame) + 1;
    }  // never 0, the initial value

    mutable std::mutex m_mutex;
    rhi::Buffer m_words;
    std::vector<Frame> m_frames;  // by slot
    size_t m_slot = 0;
};

}  // namespace raygraph
