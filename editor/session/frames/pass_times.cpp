#include "editor/session/frames/pass_times.h"

#include <numeric>

#include "base/median.h"

namespace raygraph::session {

void PassTimes::Add(const FrameTiming& frame) {
    std::map<std::string_view, double> inFrame;
    for (const PassTiming& pass : frame.passes) {
        if (!m_times.contains(pass.name)) {
            m_order.push_back(pass.name);
            m_times[pass.name];
        }
        inFrame[pass.name] += pass.gpuMs;
    }
    for (const auto& [name, ms] : inFrame) m_times.find(name)->second.push_back(ms);
}

void PassTimes::Add(std::span<const FrameTiming> frames) {
    for (const FrameTiming& frame : frames) Add(frame);
}

std::vector<PassTime> PassTimes::Summary() const {
    std::vector<PassTime> summary;
    for (const std::string& name : m_order)
        summary.push_back(
            {name, MedianMs(name), TotalMs(name), static_cast<uint32_t>(m_times.find(name)->second.size())});
    return summary;
}

double PassTimes::MedianMs(std::string_view name) const {
    const auto times = m_times.find(name);
    return times == m_times.end() ? 0.0 : Median(times->second);
}

double PassTimes::TotalMs(std::string_view name) const {
    const auto times = m_times.find(name);
    return times == m_times.end() ? 0.0 : std::accumulate(times->second.begin(), times->second.end(), 0.0);
}

}  // namespace raygraph::session
