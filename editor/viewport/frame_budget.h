// FrameBudget: how much of a picture may be traced in a frame, learned from the times of the frames before.
// Pure: no device.
#pragma once

#include <array>
#include <cstdint>

#include "passes/tiles.h"

namespace raygraph::viewport {

// Where rays are expensive. A pixel's cost hardly depends on the resolution, but a lot on what it sees: it is
// kept by height, in bands of the picture, for tiles are rows. Costs rise at once and fall by halves, so that
// a surprise is not repeated.
class FrameBudget {
  public:
    // Milliseconds of a submission; 0: no limit.
    void SetLimit(double milliseconds) { m_limitMs = milliseconds; }
    double Limit() const { return m_limitMs; }
    bool IsLimited() const { return m_limitMs > 0.0; }

    // Nothing that was learned holds any more: another scene, other settings.
    void Forget();
    // Tracing these pixels of a picture `height` rows high took that long.
    void LearnTile(uint32_t height, const passes::Region& tile, double milliseconds);
    // All the rest of a submission.
    void LearnOverhead(double milliseconds);
    // A frame of the raster view alone, of so many pixels.
    void LearnRaster(uint64_t pixels, double milliseconds);

    // Milliseconds that a frame has for tracing.
    double TracingMs() const;
    // Expected milliseconds; those of pixels never seen are taken as the most expensive ones.
    double Expect(uint32_t height, const passes::Region& tile) const;
    // Pixels from the cursor on that take about `milliseconds`, at least one; without a limit, all. Not more
    // than four times what has been measured at once, and kFirstPixels where nothing has.
    uint64_t Affordable(rhi::Extent2D picture, const passes::TileCursor& cursor, double milliseconds) const;
    bool HasLearned() const { return m_mostPixels > 0; }
    // The power of two by which a raster picture is coarser, so that it keeps to the limit; 1: not at all, or
    // nothing is known. At most 16.
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
