// FrameBudget learns from the times of earlier frames how much of a picture may be traced in a frame. Pure:
// it needs no device.
#pragma once

#include <array>
#include <cstdint>

#include "passes/tiles.h"

namespace raygraph::viewport {

// Estimates the cost of tracing by position in the picture. A pixel's cost hardly depends on the resolution,
// but much on what it sees. Tiles are rows, so costs are stored by height, in bands of the picture. Costs
// rise at once and fall by halves, so that one surprise is not repeated.
class FrameBudget {
  public:
    // Sets the limit of a submission, in milliseconds; 0: no limit.
    void SetLimit(double milliseconds) { m_limitMs = milliseconds; }
    double Limit() const { return m_limitMs; }
    bool IsLimited() const { return m_limitMs > 0.0; }

    // Discards all estimates, for another scene or other settings.
    void Reset();
    // Records that tracing this tile of a picture with `height` rows took `milliseconds`.
    void AddTileTiming(uint32_t height, const passes::Region& tile, double milliseconds);
    // Records the time of everything else in a submission.
    void AddOverheadTiming(double milliseconds);
    // Records the time to draw so many pixels of a raster view, without the rest of that frame: a coarser
    // picture would not make that shorter.
    void AddRasterTiming(uint64_t pixels, double milliseconds);

    // Returns the milliseconds of a frame that are available for tracing.
    double TracingMs() const;
    // Returns the expected milliseconds; pixels that were never traced count as the most expensive ones.
    double Expect(uint32_t height, const passes::Region& tile) const;
    // Returns how many pixels from the cursor on take about `milliseconds`, at least one; without a limit,
    // all. It is at most four times the largest measured number, and kFirstPixels if there is none.
    uint64_t PixelsWithin(rhi::Extent2D picture, const passes::TileCursor& cursor, double milliseconds) const;
    bool HasTimings() const { return m_mostPixels > 0; }
    // Returns the power of two by which a raster picture must be coarser to stay within the limit, at most
    // 16; 1: full resolution, or no estimate yet.
    uint32_t RasterScale(uint64_t pixels) const;

    static constexpr uint64_t kFirstPixels = 1024;

  private:
    static constexpr uint32_t kBands = 32;
    double CostAt(uint32_t height, uint32_t row) const;

    double m_limitMs = 0.0;
    std::array<double, kBands> m_msPerPixel{};  // 0: unknown
    double m_overheadMs = 0.0;
    uint64_t m_mostPixels = 0;        // in one submission, measured
    double m_rasterMsPerPixel = 0.0;  // 0: unknown
};

}  // namespace raygraph::viewport
