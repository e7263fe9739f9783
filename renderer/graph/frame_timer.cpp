#include "renderer/graph/frame_timer.h"

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "renderer/graph/pass_declaration.h"

namespace raygraph {

FrameTimer::FrameTimer(rhi::Device& device, bool gpuTimes, size_t kept) : m_device(device), m_kept(kept) {
    if (gpuTimes && device.Info().timestampValidBits > 0)
        m_timestamps = std::make_unique<rhi::TimestampPool>(device, "pass times", PassMarks::kMaxPasses + 1);
}

FrameTiming FrameTimer::NewTiming() {
    if (m_unused.empty()) return {};
    FrameTiming timing = std::move(m_unused.back());
    m_unused.pop_back();
    return timing;
}

void FrameTimer::BeginFrame(rhi::CommandList& commands) {
    m_batches.clear();
    if (!m_timestamps) return;
    Poll();
    m_timestamps->BeginFrame(commands);
    Stamp(commands);
}

void FrameTimer::BeginBatch(rhi::CommandList& commands, uint32_t firstPass) {
    if (!m_timestamps) return;
    m_batches.push_back(firstPass);
    Stamp(commands);
}

void FrameTimer::Stamp(rhi::CommandList& commands) {
    if (m_timestamps) m_timestamps->Write(commands);
}

void FrameTimer::EndFrame(uint64_t submitted, FrameTiming timing) {
    if (m_timestamps) m_timestamps->EndFrame(submitted);
    m_pending.push_back({submitted, std::move(timing), m_batches});
}

void FrameTimer::StoreTiming(FrameTiming timing) {
    for (const PassTiming& pass : timing.passes)
        if (pass.kind == PassKind::AccelerationStructure && pass.gpuMs > 0.0)
            WriteLog(m_device.Log(), LogLevel::Debug, log_category::kGeometry, "{} of frame {} took {}",
                     pass.name, timing.frame, DurationText(1e-3 * pass.gpuMs));
    if (m_kept == 0) {
        std::swap(m_latest, timing);
        m_unused.push_back(std::move(timing));
        return;
    }
    m_latest = timing;
    if (m_arrived.size() < m_kept) {
        m_arrived.push_back(std::move(timing));
        return;
    }
    std::swap(m_arrived[m_oldest], timing);
    m_oldest = (m_oldest + 1) % m_kept;
    m_unused.push_back(std::move(timing));
}

FrameTiming FrameTimer::TakePending() {
    FrameTiming timing = std::move(m_pending.front().timing);
    m_pending.erase(m_pending.begin());
    return timing;
}

void FrameTimer::Poll() {
    if (!m_timestamps) {
        const uint64_t completed = m_device.CompletedValue();
        while (!m_pending.empty() && m_pending.front().submitted <= completed) StoreTiming(TakePending());
        return;
    }
    while (const rhi::TimestampFrame* frame = m_timestamps->Poll()) {
        // Frames before it have lost their timestamps.
        while (!m_pending.empty() && m_pending.front().submitted < frame->submitted)
            m_unused.push_back(TakePending());
        if (m_pending.empty() || m_pending.front().submitted != frame->submitted) continue;
        const std::vector<uint32_t> batches = std::move(m_pending.front().batches);
        FrameTiming timing = TakePending();
        // A pass lies between two timestamps, and each further submission begins with one of its own.
        size_t batch = 0;
        for (size_t i = 0; i < timing.passes.size(); ++i) {
            while (batch < batches.size() && batches[batch] <= i) ++batch;
            const size_t before = i + batch;
            if (before + 1 >= frame->nanoseconds.size()) break;
            timing.passes[i].gpuMs = (frame->nanoseconds[before + 1] - frame->nanoseconds[before]) * 1e-6;
        }
        StoreTiming(std::move(timing));
    }
}

std::vector<FrameTiming> FrameTimer::TakeAll() {
    std::ranges::rotate(m_arrived, m_arrived.begin() + static_cast<ptrdiff_t>(m_oldest));
    m_oldest = 0;
    return std::exchange(m_arrived, {});
}

}  // namespace raygraph
