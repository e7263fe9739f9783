// Measures the error of the picture for SampleFrames.
#include "base/check.h"
#include "editor/session/frames/sample_frames.h"
#include "editor/session/settings/error_goal.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::session {

void SampleFrames::MeasureError() {
    if (m_measurement || !m_plan.withVariance || !ShowsLight()) return;
    m_renderer.BeginFrame();
    const passes::AccumulatedIds ids = Resolve(m_radiance.accumulation, Size(), true, DeclareCounts());
    m_measurement = Measurement{m_submitted, m_renderer.ReadBack(ids.mean), m_renderer.ReadBack(ids.variance),
                                m_adaptive ? m_adaptive->Counts().State().counts : std::vector<uint32_t>{}};
    m_renderer.Execute();
}

MeasuredError SampleFrames::MeasureErrorNow() {
    if (m_measurement && m_measurement->sampleCount != m_submitted) m_measurement.reset();
    MeasureError();
    RG_CHECK(m_measurement.has_value());
    m_measurement->mean.Wait();
    m_measurement->variance.Wait();
    return *NewestError();
}

const std::optional<MeasuredError>& SampleFrames::NewestError() {
    if (m_measurement && m_measurement->mean.IsReady() && m_measurement->variance.IsReady()) {
        m_error = session::MeasureError(WaitForValues<float>(m_measurement->mean),
                                        WaitForValues<float>(m_measurement->variance),
                                        m_measurement->sampleCount, m_measurement->counts);
        m_measurement.reset();
    }
    return m_error;
}

passes::ExactSums SampleFrames::RadianceSums() {
    if (m_submitted == 0) return passes::MakeExactSums(PixelCount(Size()), true);
    m_renderer.BeginFrame();
    const passes::SumsReadback sums(m_renderer,
                                    passes::Resolve(m_renderer, m_radiance.accumulation, Size(), true));
    m_renderer.Execute();
    return sums.Values();
}

}  // namespace raygraph::session
