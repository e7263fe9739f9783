// Tiles: a picture made part by part. Pure values, no device. Threads: any; one TileCursor for one thread
// at a time.
#pragma once

#include <cstdint>

#include "base/api.h"
#include "rhi/format.h"

namespace raygraph::passes {

// Describes a rectangle of a picture, in pixels from the upper left corner.
struct Region {
    uint32_t x = 0;
    uint32_t y = 0;
    uint32_t width = 0;
    uint32_t height = 0;

    bool operator==(const Region&) const = default;
    bool IsEmpty() const { return width == 0 || height == 0; }
    rhi::Extent2D Extent() const { return {width, height}; }
    uint64_t PixelCount() const { return uint64_t{width} * height; }
};

// Returns all of a picture.
RAYGRAPH_API Region WholeOf(rhi::Extent2D picture);

// Throws Error{Usage} naming both unless the region has pixels, and all of them are in the picture.
RAYGRAPH_API void RequireWithin(rhi::Extent2D picture, const Region& region);

// The progress of one sample of a picture: everything above row `y` is done, and of the `bandHeight` rows
// from there on the first `x` pixels. Tiles are whole rows, or part of a band of rows where a few rows would
// be too much.
class RAYGRAPH_API TileCursor {
  public:
    // Returns the next tile: about `pixels` pixels, at least one, never more than remain. The cursor stays.
    Region Next(rhi::Extent2D picture, uint64_t pixels) const;
    // Returns whether Next returns this tile for some count of pixels.
    bool IsNext(rhi::Extent2D picture, const Region& tile) const;
    // Moves past `tile`, which Next has returned. Returns true if that was the last one; the cursor is then
    // back at the start.
    bool Advance(rhi::Extent2D picture, const Region& tile);

    bool IsAtStart() const { return m_x == 0 && m_y == 0; }
    // Returns whether the sample has this pixel already.
    bool Has(uint32_t x, uint32_t y) const { return y < m_y || (y < m_y + m_bandHeight && x < m_x); }
    // Returns the number of pixels that are done.
    uint64_t PixelCount(rhi::Extent2D picture) const;
    uint32_t X() const { return m_x; }
    uint32_t Y() const { return m_y; }
    uint32_t BandHeight() const { return m_bandHeight; }

    // A band that was begun has this many rows, or the remaining ones.
    static constexpr uint32_t kBandHeight = 8;

    bool operator==(const TileCursor&) const = default;

  private:
    uint32_t m_x = 0;
    uint32_t m_y = 0;
    uint32_t m_bandHeight = 0;  // 0 where x is
};

}  // namespace raygraph::passes
