#include "editor/app/frame_statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/text.h"

namespace raygraph::editor {

std::vector<MemoryRow> MemoryRows(const rhi::MemoryStatistics& memory,
                                  std::span<const rhi::MemoryHeap> heaps) {
    std::vector<MemoryRow> rows{
        {"memory", BytesText(memory.usedBytes) + ", peak " + BytesText(memory.peakBytes)}};
    if (memory.fallbackBytes > 0)
        rows.push_back({"", BytesText(memory.fallbackBytes) + " in the host's memory: the device's is full"});
    for (const rhi::MemoryHeap& heap : heaps)
        rows.push_back({heap.isDeviceLocal ? "device heap" : "host heap",
                        BytesText(heap.usedBytes) + " of " + BytesText(heap.budgetBytes)});
    return rows;
}

void FrameHistory::Add(const FrameTiming& timing) {
    Timed frame;
    frame.cpuMs = static_cast<float>(timing.declareMs + timing.compileMs + timing.recordMs + timing.submitMs);
    for (const PassTiming& pass : timing.passes) {
        const auto found = std::ranges::find(m_names, pass.name);
        const auto index = static_cast<size_t>(found - m_names.begin());
        if (found == m_names.end()) m_names.push_back(pass.name);
        frame.passes.emplace_back(index, static_cast<float>(pass.gpuMs));
    }
    m_frames.push_back(std::move(frame));
    if (m_frames.size() > kLength) m_frames.pop_front();
}

std::vector<float> FrameHistory::Gpu() const {
    std::vector<float> times;
    for (const Timed& frame : m_frames)
        times.push_back(std::accumulate(frame.passes.begin(), frame.passes.end(), 0.0f,
                                        [](float sum, const auto& pass) { return sum + pass.second; }));
    return times;
}

std::vector<float> FrameHistory::Cpu() const {
    std::vector<float> times;
    for (const Timed& frame : m_frames) times.push_back(frame.cpuMs);
    return times;
}

std::vector<FrameHistory::Pass> FrameHistory::Passes() const {
    std::vector<Pass> passes;
    for (const std::string& name : m_names)
        passes.push_back({.name = name, .ms = std::vector<float>(m_frames.size(), 0.0f)});
    for (size_t i = 0; i < m_frames.size(); ++i)
        for (const auto& [index, ms] : m_frames[i].passes) passes[index].ms[i] += ms;
    std::erase_if(passes, [](Pass& pass) {
        const float sum = std::accumulate(pass.ms.begin(), pass.ms.end(), 0.0f);
        pass.mean = pass.ms.empty() ? 0.0f : sum / static_cast<float>(pass.ms.size());
        return sum == 0.0f;
    });
    std::ranges::stable_sort(passes, [](const Pass& a, const Pass& b) { return a.mean > b.mean; });
    return passes;
}

void SampleRate::Add(double seconds, double samples) {
    if (!m_points.empty() && samples < m_points.back().samples) m_points.clear();
    m_points.push_back({seconds, samples});
    // Keep one point just before the span
    while (m_points.size() > 2 && m_points[1].seconds < seconds - kSpan) m_points.pop_front();
}

std::optional<double> SampleRate::PerSecond() const {
    if (m_points.size() < 2) return std::nullopt;
    const double span = m_points.back().seconds - m_points.front().seconds;
    if (span < 0.25) return std::nullopt;
    return (m_points.back().samples - m_points.front().samples) / span;
}

void RealTimeErrorHistory::Add(const viewport::RealTimeErrors& errors) {
    m_errors.push_back(errors);
    if (m_errors.size() > kLength) m_errors.pop_front();
}

std::vector<RealTimeErrorHistory::Curve> RealTimeErrorHistory::Curves() const {
    if (IsEmpty()) return {};
    const std::string against = Counted(m_errors.back().referenceSamples, "sample");
    std::vector<Curve> curves;
    const auto add = [&](const std::string& name, auto&& valueOf) {
        Curve curve;
        for (const viewport::RealTimeErrors& errors : m_errors) {
            const std::optional<double> value = valueOf(errors);
            curve.values.push_back(value ? std::optional(static_cast<float>(*value)) : std::nullopt);
        }
        const std::optional<float> newest = curve.values.back();
        curve.text = Text("{:>9} {}", newest ? Text("{:.2g}", *newest) : "-", name);
        curves.push_back(std::move(curve));
    };
    using Errors = viewport::RealTimeErrors;
    add(Text("relMSE against {}", against),
        [](const Errors& e) { return std::optional(e.relativeSquaredError); });
    add("of this, noise of the reference", [](const Errors& e) { return e.referenceNoise; });
    add(Text("FLIP against {}", against), [](const Errors& e) { return std::optional(e.flip); });
    add("flicker of the last second", [](const Errors& e) { return e.flicker; });
    return curves;
}

float OnLogAxis(float value, float from, float to) {
    if (!(value > from)) return 0.0f;
    return std::min(std::log(value / from) / std::log(to / from), 1.0f);
}

double SecondsLeft(double error, double target, double samples, double samplesPerSecond) {
    const double times = error / target;
    return std::max(0.0, samples * (times * times - 1.0) / samplesPerSecond);
}

}  // namespace raygraph::editor
