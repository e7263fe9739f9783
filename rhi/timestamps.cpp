#include "rhi/timestamps.h"

#include <algorithm>

#include "base/text.h"
#include "rhi/device.h"

namespace raygraph::rhi {

TimestampPool::TimestampPool(Device& device, const std::string& name, uint32_t maxPerFrame)
    // There is one range more than frames in flight: the frame that has just completed can still be read
    // while they run.
    : m_device(device), m_maxPerFrame(maxPerFrame), m_ranges(device.FramesInFlight() + 1) {
    const std::string subject = "timestamp pool '" + name + "'";
    if (device.Info().timestampValidBits == 0)
        throw MakeError(ErrorKind::Usage, "{}: {} has no timestamps", subject, device.Info().name);
    if (maxPerFrame == 0) throw MakeError(ErrorKind::Usage, "{}: its size is zero", subject);
    VkQueryPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = maxPerFrame * static_cast<uint32_t>(m_ranges.size());
    device.Check(device.Vk().vkCreateQueryPool(device.Handle(), &info, device.AllocationCallbacks(), &m_pool),
                 subject + ": vkCreateQueryPool");
    device.SetName(VK_OBJECT_TYPE_QUERY_POOL, reinterpret_cast<uint64_t>(m_pool), name);
}

TimestampPool::~TimestampPool() {
    m_device.Retire([device = &m_device, pool = m_pool] {
        device->Vk().vkDestroyQueryPool(device->Handle(), pool, device->AllocationCallbacks());
    });
}

void TimestampPool::BeginFrame(CommandList& commands) {
    if (m_ranges[m_current].state != State::Recording) m_current = (m_current + 1) % m_ranges.size();
    Range& range = m_ranges[m_current];
    if (range.state == State::Submitted) ++m_lostCount;
    range = {State::Recording, 0, 0};
    m_device.Vk().vkCmdResetQueryPool(commands.Handle(), m_pool, FirstQuery(m_current), m_maxPerFrame);
}

std::optional<uint32_t> TimestampPool::Write(CommandList& commands, VkPipelineStageFlags2 stage) {
    Range& range = m_ranges[m_current];
    if (range.state != State::Recording || range.count == m_maxPerFrame) return std::nullopt;
    commands.WriteTimestamp(m_pool, FirstQuery(m_current) + range.count, stage);
    return range.count++;
}

void TimestampPool::EndFrame(uint64_t submitted) {
    Range& range = m_ranges[m_current];
    if (range.state != State::Recording) return;
    range.state = State::Submitted;
    range.submitted = submitted;
}

const TimestampFrame* TimestampPool::Poll() {
    const uint64_t completed = m_device.CompletedValue();
    // The oldest range is the one after the current one.
    for (size_t i = 1; i <= m_ranges.size(); ++i) {
        const size_t index = (m_current + i) % m_ranges.size();
        Range& range = m_ranges[index];
        if (range.state != State::Submitted) continue;
        if (range.submitted > completed) return nullptr;
        range.state = State::Free;
        m_polled.submitted = range.submitted;
        m_polled.nanoseconds.clear();
        if (range.count == 0) return &m_polled;
        m_ticks.resize(range.count);
        m_device.Check(
            m_device.Vk().vkGetQueryPoolResults(m_device.Handle(), m_pool, FirstQuery(index), range.count,
                                                m_ticks.size() * sizeof(uint64_t), m_ticks.data(),
                                                sizeof(uint64_t), VK_QUERY_RESULT_64_BIT),
            "vkGetQueryPoolResults");
        // The counter may have fewer than 64 bits, and wrap around between two ticks: their difference is
        // correct modulo 2^bits, read as a signed number.
        const uint32_t unused = 64 - std::min(m_device.Info().timestampValidBits, 64u);
        for (const uint64_t tick : m_ticks) {
            const auto difference = static_cast<int64_t>((tick - m_ticks[0]) << unused) >> unused;
            m_polled.nanoseconds.push_back(static_cast<double>(difference) *
                                           m_device.Info().timestampPeriodNs);
        }
        return &m_polled;
    }
    return nullptr;
}

}  // namespace raygraph::rhi
