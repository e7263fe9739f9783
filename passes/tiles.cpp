#include "passes/tiles.h"

#include <algorithm>
#include <string>

#include "base/text.h"

namespace raygraph::passes {

namespace {

uint32_t AtMost(uint64_t count, uint32_t limit) {
    return static_cast<uint32_t>(std::clamp<uint64_t>(count, 1, limit));
}

}  // namespace

Region WholeOf(rhi::Extent2D picture) {
    return {0, 0, picture.width, picture.height};
}

void RequireWithin(rhi::Extent2D picture, const Region& region) {
    if (!region.IsEmpty() && region.x < picture.width && region.width <= picture.width - region.x &&
        region.y < picture.height && region.height <= picture.height - region.y)
        return;
    throw MakeError(ErrorKind::Usage, "a region of {}x{} pixels from {}, {} on, in a picture of {}x{}",
                    region.width, region.height, region.x, region.y, picture.width, picture.height);
}

Region TileCursor::Next(rhi::Extent2D picture, uint64_t pixels) const {
    const uint32_t left = picture.height - m_y;
    if (m_x == 0 && pixels >= picture.width)
        return {0, m_y, picture.width, AtMost(pixels / picture.width, left)};
    const uint32_t height = m_x == 0 ? std::min(kBandHeight, left) : m_bandHeight;
    return {m_x, m_y, AtMost(pixels / height, picture.width - m_x), height};
}

bool TileCursor::IsNext(rhi::Extent2D picture, const Region& tile) const {
    if (tile.IsEmpty() || tile.x != m_x || tile.y != m_y) return false;
    if (tile.width > picture.width - m_x || tile.height > picture.height - m_y) return false;
    if (m_x > 0) return tile.height == m_bandHeight;
    return tile.width == picture.width || tile.height == std::min(kBandHeight, picture.height - m_y);
}

bool TileCursor::Advance(rhi::Extent2D picture, const Region& tile) {
    m_x += tile.width;
    m_bandHeight = tile.height;
    if (m_x < picture.width) return false;
    m_x = m_bandHeight = 0;
    m_y += tile.height;
    if (m_y < picture.height) return false;
    m_y = 0;
    return true;
}

uint64_t TileCursor::PixelCount(rhi::Extent2D picture) const {
    return uint64_t{m_y} * picture.width + uint64_t{m_x} * m_bandHeight;
}

}  // namespace raygraph::passes
