#include "editor/viewport/frame_budget.h"

#include <algorithm>
#include <cmath>

namespace raygraph::viewport {

namespace {

// This fraction of the limit is used; the rest is a reserve for unforeseen work.
constexpr double kAim = 0.7;
// This fraction of the limit is always for tracing, whatever the rest takes: otherwise no sample would ever
// be completed.
constexpr double kMinShare = 0.25;
constexpr uint64_t kGrowth = 4;

}  // namespace

void FrameBudget::Reset() {
    m_msPerPixel.fill(0.0);
    m_mostPixels = 0;
    m_overheadMs = 0.0;
    m_rasterMsPerPixel = 0.0;
}

void FrameBudget::AddTileTiming(uint32_t height, const passes::Region& tile, double milliseconds) {
    const uint64_t pixels = tile.PixelCount();
    if (pixels == 0 || height == 0 || !(milliseconds > 0.0)) return;
    const double cost = milliseconds / static_cast<double>(pixels);
    const uint32_t last = tile.y + tile.height - 1;
    for (uint32_t band = tile.y * kBands / height; band <= last * kBands / height; ++band) {
        double& known = m_msPerPixel[std::min(band, kBands - 1)];
        known = cost > known ? cost : 0.5 * (known + cost);
    }
    m_mostPixels = std::max(m_mostPixels, pixels);
}

void FrameBudget::AddOverheadTiming(double milliseconds) {
    m_overheadMs = m_overheadMs == 0.0 ? milliseconds : 0.5 * (m_overheadMs + milliseconds);
}

void FrameBudget::AddRasterTiming(uint64_t pixels, double milliseconds) {
    const double cost = milliseconds / static_cast<double>(std::max<uint64_t>(1, pixels));
    m_rasterMsPerPixel = cost > m_rasterMsPerPixel ? cost : 0.5 * (cost + m_rasterMsPerPixel);
}

uint32_t FrameBudget::RasterScale(uint64_t pixels) const {
    constexpr uint32_t kMaxScale = 16;
    if (!IsLimited()) return 1;
    const auto isTooSlow = [&](uint32_t scale) {
        return static_cast<double>(pixels / (uint64_t{scale} * scale)) * m_rasterMsPerPixel >
               kAim * m_limitMs;
    };
    uint32_t scale = 1;
    while (scale < kMaxScale && isTooSlow(scale)) scale *= 2;
    return scale;
}

double FrameBudget::TracingMs() const {
    return std::max(kMinShare * m_limitMs, kAim * m_limitMs - m_overheadMs);
}

double FrameBudget::CostAt(uint32_t height, uint32_t row) const {
    const double known = m_msPerPixel[std::min(row * kBands / height, kBands - 1)];
    return known > 0.0 ? known : *std::max_element(m_msPerPixel.begin(), m_msPerPixel.end());
}

double FrameBudget::Expect(uint32_t height, const passes::Region& tile) const {
    double sum = 0.0;
    for (uint32_t row = tile.y; row < tile.y + tile.height; ++row) sum += tile.width * CostAt(height, row);
    return sum;
}

uint64_t FrameBudget::PixelsWithin(rhi::Extent2D picture, const passes::TileCursor& cursor,
                                   double milliseconds) const {
    if (!IsLimited()) return uint64_t{picture.width} * picture.height;
    if (!HasTimings()) return kFirstPixels;
    uint64_t pixels = 0;
    double left = milliseconds;
    uint32_t row = cursor.Y();
    // A band that has been begun is completed first
    const uint32_t bandEnd = std::min(picture.height, row + cursor.BandHeight());
    uint64_t width = picture.width - cursor.X();
    for (; row < picture.height; ++row) {
        if (row >= bandEnd) width = picture.width;
        const double cost = CostAt(picture.height, row), rowMs = static_cast<double>(width) * cost;
        if (rowMs > left) {
            pixels += static_cast<uint64_t>(std::max(left, 0.0) / cost);
            break;
        }
        left -= rowMs;
        pixels += width;
    }
    return std::clamp<uint64_t>(pixels, 1, kGrowth * m_mostPixels);
}

}  // namespace raygraph::viewport
