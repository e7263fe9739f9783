// KeptDisplay: a picture as a screen shows it, kept over frames: a frame tone-maps what it has changed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "passes/accumulate.h"
#include "passes/tonemap.h"

namespace raygraph::viewport {

class KeptDisplay {
  public:
    explicit KeptDisplay(std::string name) : m_name(std::move(name)) {}

    // An accumulated picture in the open frame.
    struct Source {
        TextureId mean;                                // rgba32f, of the picture's extent
        passes::Accumulation::Progress before, after;  // of `mean`: submitted, and with this frame
        std::vector<passes::Region> tiles;             // that this frame has added, in their order
        uint64_t resetCount = 0;
        // What stands in for pixels without a sample: a whole picture, coarser by that factor. Before the
        // first sample alone.
        TextureId base;
        uint32_t baseScale = 1;
        // The next finer picture, of which this frame has added that tile; invalid: none.
        TextureId finer;
        passes::Region finerTile{};
    };
    // Declares what brings the picture up to date, which may be nothing. rgba8.
    TextureId Declare(Renderer& renderer, const Source& source, const passes::TonemapSettings& tonemap);
    void Forget(Renderer& renderer) { renderer.Forget(m_name); }

  private:
    // What the texture was made of.
    struct Key {
        Extent2D extent;
        passes::TonemapSettings tonemap;
        uint64_t resetCount = 0;
        passes::Accumulation::Progress progress;
        uint32_t baseScale = 1;
    };
    bool IsValid(const Source& source, const Key& now) const;

    std::string m_name;
    std::optional<Key> m_made;
};

}  // namespace raygraph::viewport
