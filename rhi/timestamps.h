// TimestampPool: GPU times of a frame, read without waiting.
//
// Each frame uses one of a few ranges of queries; a range is read when the timeline has passed its frame, and
// then reused. A frame whose range is reused before it was read (without polling) is lost, and counted.
// Threads: one at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/api.h"
#include "rhi/command_list.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

struct TimestampFrame {
    uint64_t submitted = 0;           // the timeline value of the frame
    std::vector<double> nanoseconds;  // since the frame's first timestamp, in the order of Write
};

class RAYGRAPH_API TimestampPool {
  public:
    // Throws Error{Usage} if the device has no timestamps (DeviceInfo::timestampValidBits is 0) or
    // maxPerFrame is 0.
    TimestampPool(Device& device, const std::string& name, uint32_t maxPerFrame);
    ~TimestampPool();
    TimestampPool(const TimestampPool&) = delete;
    TimestampPool& operator=(const TimestampPool&) = delete;

    // Starts the timestamps of a frame. Must be recorded outside of rendering.
    void BeginFrame(CommandList& commands);
    // Writes a timestamp once all commands before have passed `stage`. Returns its index in
    // TimestampFrame::nanoseconds. Above maxPerFrame or outside of a frame, it writes nothing and returns
    // nullopt.
    std::optional<uint32_t> Write(CommandList& commands,
                                  VkPipelineStageFlags2 stage = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    // The frame was submitted with this timeline value. The next BeginFrame discards a frame that was not
    // submitted.
    void EndFrame(uint64_t submitted);

    // Returns the oldest completed frame that has not been returned, valid until the next call; null if there
    // is none. Never waits.
    const TimestampFrame* Poll();
    uint64_t LostFrameCount() const { return m_lostCount; }

  private:
    enum class State : uint8_t { Free, Recording, Submitted };
    struct Range {
        State state = State::Free;
        uint32_t count = 0;
        uint64_t submitted = 0;
    };
    uint32_t FirstQuery(size_t range) const { return static_cast<uint32_t>(range) * m_maxPerFrame; }

    Device& m_device;
    uint32_t m_maxPerFrame;
    std::vector<Range> m_ranges;
    size_t m_current = 0;  // range of the current frame, or of the last one
    VkQueryPool m_pool = VK_NULL_HANDLE;
    uint64_t m_lostCount = 0;
    TimestampFrame m_polled;
    std::vector<uint64_t> m_ticks;  // of m_polled
};

}  // namespace raygraph::rhi
