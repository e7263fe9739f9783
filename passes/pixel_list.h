// PixelList: the pixels of which Trace takes samples, if not all pixels get the same number. Threads: that of
// the Renderer.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/api.h"
#include "renderer/graph/renderer.h"
#include "shaders/shared/scene_records.h"

namespace raygraph::passes {

// Describes a list as passes of the open frame read it.
struct ListedPixels {
    BufferId list;         // gpu::ListedPixel, one for each texel of `extent`, in rows from the top
    uint64_t address = 0;  // device address of the list
    uint32_t count = 0;    // pixels; texels behind them are of none, and are not traced
    Extent2D extent;       // extent of a sample of these pixels in the outputs of Trace

    bool HasPixels() const { return count > 0; }
    uint32_t AddressLow() const { return static_cast<uint32_t>(address); }
    uint32_t AddressHigh() const { return static_cast<uint32_t>(address >> 32); }
};

// A list on the device. It outlives the frames that read it.
class RAYGRAPH_API PixelList {
  public:
    // Makes a list for a picture of that size, at most 65536 pixels a side.
    PixelList(rhi::Device& device, Extent2D picture);

    // Takes at least one pixel, at most as many as the picture has, and none twice.
    void Set(std::span<const gpu::ListedPixel> pixels);
    // Returns the first `count` of them, once in a frame; declares the upload where the list has changed
    // since. Rows of the outputs are those of the picture. There are so few different numbers of them that
    // frames find the textures of earlier ones again.
    ListedPixels Declare(Renderer& renderer, uint32_t count);

  private:
    Extent2D m_picture;
    rhi::Buffer m_buffer;
    ResourceState m_state;
    std::vector<gpu::ListedPixel> m_changed;  // not on the device yet
    uint32_t m_count = 0;
};

// Returns a count for each pixel, as an r32ui texture of the open frame.
[[nodiscard]] RAYGRAPH_API TextureId UploadCounts(Renderer& renderer, std::span<const uint32_t> counts,
                                                  Extent2D picture);
// Fills a texture, rows from the top, even if nothing in the frame reads it.
RAYGRAPH_API TextureId UploadTexels(Renderer& renderer, std::span<const std::byte> texels, TextureId target);

}  // namespace raygraph::passes
