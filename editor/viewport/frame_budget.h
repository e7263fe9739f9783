// FrameBudget: how much of a picture may be traced in a frame, learned from the times of the frames before.
// Pure: no device.
#pragma once

#include <array>
#include <cstdint>

#include "passes/tiles.h"

namespace raygraph::viewport {

// The cost of tracing, by place in the picture. A pixel's cost hardly depends on the resolution, but much on
// what it sees. Tiles are rows, so costs are kept by height, in bands of the picture. Costs rise at once and
// fall by halves, so that one surprise is not repeated.
class FrameBudget {
  public:
    // Milliseconds of a submission; 0: no limit.
    void SetLimit(double milliseconds) { m_limitMs = milliseconds; }
    double Limit() const { return m_limitMs; }
    bool IsLimited() const { return m_limitMs > 0.0; }

    // Discards all estimates: another scene, other settings.
    void Forget();
    // Tracing these pixels of a picture `height` rows high took `milliseconds`.
    void LearnTile(uint32_t height, const passes::Region& tile, double milliseconds);
    // Everything else in a submission.
    void LearnOverhead(double milliseconds);
    // Drawing so many pixels of a raster view. What else is in that frame does not count: a coarser picture
    // would not make it shorter.
    void LearnRaster(uint64_t pixels, double milliseconds);

    // Milliseconds of a frame that are available for tracing.
    double TracingMs() const;
    // Expected milliseconds; pixels that were never traced count as the most expensive ones.
    double Expect(uint32_t height, const passes::Region& tile) const;
    // Pixels from the cursor on that take about `milliseconds`, at least one; without a limit, all. Not more
    // than four times what has been measured at once, and kFirstPixels where nothing has.
    uint64_t Affordable(rhi::Extent2D picture, const passes::TileCursor& cursor, double milliseconds) const;
    bool HasLearned() const { return m_mostPixels > 0; }
    // The power of two by which a raster picture is coarser, so that it stays within the limit; 1: full
    // resolution, or no estimate yet. At most 16.
    uint32_t RasterScale(uint64_t pixels) const;

    static constexpr uint64_t kFirstPixels = 1024;

  private:
    static constexpr uint32_t kBands = 32;
    double CostAt(uint32_t height, uint32_t row) const;

    double m_limitMs = 0.0;
    std::array<double, kBands> m_msPerPixel{};  // 0: not known
    double m_overheadMs = 0.0;
    uint64_t m_mostPixels = 0;        // measured in one submission
    double m_rasterMsPerPixel = 0.0;  // 0: not known
};

}  // namespace raygraph::viewport
