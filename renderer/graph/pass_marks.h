// PassMarks: the pass that the device had reached, readable after it is lost.
//
// Before a pass runs, and after its waits are over, the device writes the frame's number into that pass's
// word of mapped memory. Every pass and every frame in flight has words of its own, so that no two writes
// ever conflict. A word that holds the number means that everything the pass waited for had completed.
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

    // Starts a frame's marks. A frame framesInFlight later reuses their memory.
    void BeginFrame(uint64_t frame);
    // The next pass begins. Recorded outside of rendering, after its barriers, which must make transfers
    // wait too.
    void Mark(rhi::CommandList& commands, const std::string& pass);
    // Returns the last mark of the newest frame that has one, `the last pass reached was pass "Trace" (2 of
    // 3) of frame 12`; empty if there is none. Any thread.
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
    }  // never the initial 0

    mutable std::mutex m_mutex;
    rhi::Buffer m_words;
    std::vector<Frame> m_frames;  // by slot
    size_t m_slot = 0;
};

}  // namespace raygraph
