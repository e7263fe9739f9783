#include "editor/session/group/device_render.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "base/stopwatch.h"

namespace raygraph::session {
namespace {

constexpr uint32_t kMostAtStep = 1u << 16;  // samples of a pixel, on average

}  // namespace

void DeviceRender::Estimate() {
    // Estimate at the first count that reaches each power of two
    const int width = std::bit_width(m_frames->SamplesSubmitted());
    if (std::exchange(m_estimatedWidth, width) != width) m_frames->MeasureError();
    const std::optional<MeasuredError>& error = m_frames->NewestError();
    if (error && error->relativeError)
        m_errorOfOneSample.store(*error->relativeError * std::sqrt(static_cast<double>(error->samples)),
                                 std::memory_order_relaxed);
}

void DeviceRender::RenderBlocks(BlockSource& source, uint32_t device, bool isEstimating,
                                const std::function<void()>& afterSamples) {
    // Measured by what the device has finished: frames are in flight
    Stopwatch watch;
    uint32_t doneBefore = m_frames->SamplesDone();
    const auto samples = [&] { return m_samples + (m_frames->SamplesDone() - doneBefore); };
    const auto speed = [&] {
        return m_isWarm && samples() > 0.0 ? samples() / (m_seconds + watch.Seconds()) : 0.0;
    };
    while (const auto block = source.Next(device, speed())) {
        for (uint32_t done = 0; done < block->count;) {
            const uint32_t count = std::min(block->count - done, PreferredBatchSize());
            m_frames->RenderSamples({block->first + done, count});
            done += count;
            if (!m_isWarm) {
                m_frames->WaitForSamples();
                doneBefore = m_frames->SamplesDone();
                watch = {};
                m_isWarm = true;
            }
            if (isEstimating) Estimate();
            if (afterSamples) afterSamples();
        }
    }
    m_frames->WaitForSamples();
    if (!m_isWarm) return;
    m_samples = samples();
    m_seconds += watch.Seconds();
}

void DeviceRender::RenderAdaptive(uint32_t average, bool isEstimating,
                                  const std::function<bool()>& afterFrames) {
    // A run may end between two steps: they take about as long, whatever a sample takes
    constexpr double kShortest = 0.1, kLongest = 0.5;
    do {
        const Stopwatch watch;
        m_frames->RenderAdaptive(average, m_step);
        const double seconds = watch.Seconds();
        if (seconds > kLongest)
            m_step = std::max(m_step / 2, 1u);
        else if (seconds < kShortest)
            m_step = std::min(2 * m_step, kMostAtStep);
        if (isEstimating) Estimate();
    } while (!afterFrames() && m_frames->SamplesSubmitted() < average);
    m_frames->WaitForSamples();
}

}  // namespace raygraph::session
