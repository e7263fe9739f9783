#include "renderer/graph/frame_timer.h"

#include <iterator>

#include "base/text.h"
#include "renderer/graph/pass_declaration.h"

namespace raygraph {

namespace {

// A limit, because the caller may never take the timings.
constexpr size_t kMaxArrived = 4096;

}  // namespace

FrameTimer::FrameTimer(rhi::Device& device, bool gpuTimes) : m_device(device) {
    if (gpuTimes && device.Info().timestampValidBits > 0)
        m_timestamps = std::make_unique<rhi::TimestampPool>(device, "pass times", PassMarks::kMaxPasses + 1);
}

void FrameTimer::BeginFrame(rhi::CommandList& commands) {
    if (!m_timestamps) return;
    Poll();
    m_timestamps->BeginFrame(commands);
    Stamp(commands);
}

void FrameTimer::Stamp(rhi::CommandList& commands) {
    if (m_timestamps) m_timestamps->Write(commands);
}

void FrameTimer::EndFrame(uint64_t submitted, FrameTiming timing) {
    if (m_timestamps) m_timestamps->EndFrame(submitted);
    m_pending.push_back({submitted, std::move(timing)});
}

void FrameTimer::StoreTiming(FrameTiming timing) {
    for (const PassTiming& pass : timing.passes)
        if (pass.kind == PassKind::AccelerationStructure && pass.gpuMs > 0.0)
            WriteLog(m_device.Log(), LogLevel::Debug, log_category::kGeometry, "{} of frame {} took {}",
                     pass.name, timing.frame, DurationText(1e-3 * pass.gpuMs));
    m_latest = timing;
    m_arrived.push_back(std::move(timing));
    if (m_arrived.size() > kMaxArrived) m_arrived.pop_front();
}

void FrameTimer::Poll() {
    if (!m_timestamps) {
        const uint64_t completed = m_device.CompletedValue();
        for (; !m_pending.empty() && m_pending.front().submitted <= completed; m_pending.pop_front())
            StoreTiming(std::move(m_pending.front().timing));
        return;
    }
    while (const std::optional<rhi::TimestampFrame> frame = m_timestamps->Poll()) {
        // Frames before it have lost their timestamps.
        while (!m_pending.empty() && m_pending.front().submitted < frame->submitted) m_pending.pop_front();
        if (m_pending.empty() || m_pending.front().submitted != frame->submitted) continue;
        FrameTiming timing = std::move(m_pending.front().timing);
        m_pending.pop_front();
        for (size_t i = 0; i < timing.passes.size() && i + 1 < frame->nanoseconds.size(); ++i)
            timing.passes[i].gpuMs = (frame->nanoseconds[i + 1] - frame->nanoseconds[i]) * 1e-6;
        StoreTiming(std::move(timing));
    }
}

std::vector<FrameTiming> FrameTimer::TakeAll() {
    std::vector<FrameTiming> all(std::make_move_iterator(m_arrived.begin()),
                                 std::make_move_iterator(m_arrived.end()));
    m_arrived.clear();
    return all;
}

}  // namespace raygraph
