#include "renderer/graph/pass_series.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "renderer/graph/renderer_impl.h"

namespace raygraph {

void PassSeries::AddTimings(const FrameTiming& timing) {
    while (!m_executed.empty() && m_executed.front().frame < timing.frame) m_executed.pop_front();
    for (; !m_executed.empty() && m_executed.front().frame == timing.frame; m_executed.pop_front()) {
        const Executed& executed = m_executed.front();
        const auto timed = std::ranges::find_if(
            timing.passes, [&](const PassTiming& pass) { return pass.id.index == executed.id.index; });
        if (timed == timing.passes.end() || executed.pass >= m_passes.size() || !(timed->gpuMs > 0.0))
            continue;
        const double ms = timed->gpuMs * kParts / executed.parts;
        // It rises at once and falls by halves, so that one surprise is not repeated
        double& known = m_passes[executed.pass].ms;
        known = ms > known ? ms : 0.5 * (known + ms);
    }
}

std::string SeriesFrame::NameOf(std::string_view resource) {
    m_kept.push_back({.name = Text("{}/{} {}", m_series->m_name, m_kept.size(), resource)});
    return m_kept.back().name;
}

// Returns the milliseconds of a whole pass, or a guess; 0: nothing is known.
double SeriesFrame::CostOf(std::string_view pass, uint32_t index) const {
    const std::vector<PassSeries::Known>& known = m_series->m_passes;
    if (index < known.size() && known[index].ms > 0.0) return known[index].ms;
    double most = 0.0, mostOfName = 0.0;
    for (const PassSeries::Known& other : known) {
        most = std::max(most, other.ms);
        if (other.name == pass) mostOfName = std::max(mostOfName, other.ms);
    }
    return mostOfName > 0.0 ? mostOfName : most;
}

SeriesFrame::Parts SeriesFrame::Take(std::string_view pass, bool isDividable, PassId id, uint64_t frame) {
    constexpr uint32_t kAll = PassSeries::kParts;
    const uint32_t index = m_passCount++;
    m_names.emplace_back(pass);
    if (m_isFull || index < m_next.pass) return {};
    const uint32_t first = m_next.part, remaining = kAll - first;
    const double cost = CostOf(pass, index);
    const bool isFirst = m_executed.empty();
    uint32_t parts = remaining;
    if (std::isinf(m_leftMs)) {
        // All that is left is executed
    } else if (cost == 0.0) {
        // Nothing else may share the frame of a pass that may take long
        parts = !isFirst ? 0 : isDividable ? 1 : remaining;
        m_leftMs = 0.0;
    } else {
        const double fitting = std::max(m_leftMs, 0.0) * kAll / cost;
        if (fitting < remaining) {
            parts = isDividable ? static_cast<uint32_t>(fitting) : 0;
            if (parts == 0 && isFirst) parts = isDividable ? 1 : remaining;
        }
        m_leftMs -= cost * parts / kAll;
    }
    if (parts > 0) m_executed.push_back({.frame = frame, .id = id, .pass = index, .parts = parts});
    if (parts == remaining) {
        m_next = {.pass = index + 1};
    } else {
        m_next.part += parts;
        m_isFull = true;
    }
    return {.first = first, .end = first + parts};
}

bool SeriesFrame::Keeps(std::string_view resource) const {
    return std::ranges::find(m_kept, resource, &PassSeries::Kept::name) != m_kept.end();
}

void SeriesFrame::NoteUse(std::string_view resource) {
    const auto kept = std::ranges::find(m_kept, resource, &PassSeries::Kept::name);
    if (kept != m_kept.end()) kept->lastPass = m_passCount - 1;
}

std::vector<PassId> SeriesFrame::Taken() const {
    std::vector<PassId> passes;
    for (const PassSeries::Executed& executed : m_executed) passes.push_back(executed.id);
    return passes;
}

std::vector<std::string> SeriesFrame::Commit() {
    if (!m_isDivided) return {};
    PassSeries& series = *m_series;
    series.m_done = IsComplete() ? PassSeries::Place{} : m_next;
    series.m_passes.resize(m_names.size());
    for (size_t i = 0; i < m_names.size(); ++i)
        if (series.m_passes[i].name != m_names[i]) series.m_passes[i] = {.name = std::move(m_names[i])};
    constexpr size_t kMostExecuted = 1024;  // times that arrive later than this are lost
    for (const PassSeries::Executed& executed : m_executed) series.m_executed.push_back(executed);
    while (series.m_executed.size() > kMostExecuted) series.m_executed.pop_front();
    std::vector<std::string> unneeded;
    series.m_kept.clear();
    for (PassSeries::Kept& kept : m_kept)
        (IsComplete() || kept.lastPass < m_next.pass ? unneeded : series.m_kept)
            .push_back(std::move(kept.name));
    return unneeded;
}

}  // namespace raygraph
