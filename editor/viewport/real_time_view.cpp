#include "editor/viewport/real_time_view.h"

#include <algorithm>

#include "passes/overlay.h"

namespace raygraph::viewport {

namespace {

constexpr uint32_t kCoarsest = 8;
constexpr uint64_t kFirstPixels = uint64_t{1} << 16;  // before any time is known

Extent2D ExtentAt(Extent2D extent, uint32_t scale) {
    return {(extent.width + scale - 1) / scale, (extent.height + scale - 1) / scale};
}

uint64_t PixelsAt(Extent2D extent, uint32_t scale) {
    const Extent2D coarse = ExtentAt(extent, scale);
    return uint64_t{coarse.width} * coarse.height;
}

}  // namespace

void RealTimeView::NoteChange(passes::ResetCause cause) {
    using passes::ResetCause;
    switch (cause) {
        case ResetCause::Start:
        case ResetCause::Geometry:
            return m_history.Forget();
        case ResetCause::Material:
        case ResetCause::Light:
        case ResetCause::Environment:
        case ResetCause::Settings:
        case ResetCause::Transform:
            return m_history.NoteChange();
        case ResetCause::Camera:
        case ResetCause::Resize:
            return m_history.Interrupt();  // RealTime finds out the rest
        case ResetCause::Count:
            return;
    }
}

void RealTimeView::AddTiming(uint64_t pixels, double milliseconds) {
    if (pixels == 0 || !(milliseconds > 0.0)) return;
    const double measured = milliseconds / static_cast<double>(pixels);
    m_msPerPixel = m_msPerPixel > 0.0 ? 0.75 * m_msPerPixel + 0.25 * measured : measured;
}

std::optional<double> RealTimeView::ExpectedMs(Extent2D extent) const {
    if (!(m_msPerPixel > 0.0)) return std::nullopt;
    return m_msPerPixel * static_cast<double>(PixelsAt(extent, 1));
}

// A scale stays until another fits clearly better: history does not survive its change.
void RealTimeView::ChooseScale(Extent2D extent, double limitMs) {
    if (!(limitMs > 0.0)) {
        m_scale = 1;
        return;
    }
    if (!(m_msPerPixel > 0.0)) {
        if (m_isScaleFound) return;
        m_scale = 1;
        while (m_scale < kCoarsest && PixelsAt(extent, m_scale) > kFirstPixels) m_scale *= 2;
        return;
    }
    m_isScaleFound = true;
    const auto expected = [&](uint32_t scale) {
        return m_msPerPixel * static_cast<double>(PixelsAt(extent, scale));
    };
    while (m_scale < kCoarsest && expected(m_scale) > 1.15 * limitMs) m_scale *= 2;
    while (m_scale > 1 && expected(m_scale / 2) < 0.85 * limitMs) m_scale /= 2;
}

RealTimeView::Ids RealTimeView::Declare(Renderer& renderer, const SceneIds& scene,
                                        passes::TraceSettings settings, double limitMs, bool maySettle) {
    const Extent2D extent = settings.extent;
    Ids ids{.isSettled = maySettle && m_history.StillFrames() >= kSettledFrames};
    if (!ids.isSettled) ChooseScale(extent, limitMs);
    settings.extent = ExtentAt(extent, m_scale);
    ids.first = renderer.NextPass();
    if (ids.isSettled) {
        ids.picture = passes::LastRealTime(renderer, m_history, settings.extent);
    } else {
        settings.sampleIndex = m_history.FrameCount();
        // The reference has other samples: errors that both had would look like none
        settings.seed ^= 0x9e3779b9u;
        ids.pixels = PixelsAt(extent, m_scale);
        const TextureId sample = passes::Trace(renderer, scene, settings).radiance;
        ids.picture = passes::RealTime(renderer, scene, settings, sample, m_history);
    }
    ids.end = renderer.NextPass();
    if (m_scale > 1) ids.picture = passes::Upscale(renderer, ids.picture, extent);
    return ids;
}

}  // namespace raygraph::viewport
