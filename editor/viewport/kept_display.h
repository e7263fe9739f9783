// CachedDisplay is a tone-mapped picture that is kept over frames: a frame tone-maps only what it has
// changed.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "passes/accumulate.h"
#include "passes/tonemap.h"

namespace raygraph::viewport {

// Copies a picture into a texture of the same description that persists over frames; returns its new version.
// `onSubmitted` runs when the pass has been submitted.
TextureId Keep(Renderer& renderer, TextureId picture, TextureId kept, std::function<void()> onSubmitted = {});

class CachedDisplay {
  public:
    explicit CachedDisplay(std::string name) : m_name(std::move(name)) {}

    // Describes an accumulated picture in the open frame.
    struct Source {
        TextureId mean;                                // rgba32f, of the picture's extent
        passes::Accumulation::Progress before, after;  // progress of `mean`: submitted; with this frame
        std::vector<passes::Region> tiles;             // added by this frame, in order
        uint64_t resetCount = 0;
        // Is shown for pixels without a sample: a whole picture, coarser by baseScale. It is used only before
        // the first sample.
        TextureId base;
        uint32_t baseScale = 1;
        // Is the next finer picture, of which this frame has added finerTile; invalid: none.
        TextureId finer;
        passes::Region finerTile{};
        bool isPreview = false;  // `base` is shown whatever the samples are
    };
    // Declares the passes that update the picture, possibly none. Returns an rgba8 texture. The camera of a
    // backdrop is that of the picture.
    TextureId Declare(Renderer& renderer, const Source& source, const passes::TonemapSettings& tonemap,
                      const std::optional<passes::Backdrop>& backdrop);
    // Returns whether DeclareLast returns a picture of that extent.
    bool HasLast(Renderer& renderer, Extent2D extent) const;
    // Returns the picture of the last submitted frame; an invalid id if there is none.
    TextureId DeclareLast(Renderer& renderer) const;
    void Release(Renderer& renderer) { renderer.Release(m_name); }

  private:
    // Holds the inputs of the texture.
    struct Key {
        Extent2D extent;
        passes::TonemapSettings tonemap;
        std::optional<passes::BackdropSettings> backdrop;
        uint64_t resetCount = 0;
        passes::Accumulation::Progress progress;
        uint32_t baseScale = 1;  // 1 with a whole sample
        bool isPreview = false;

        bool operator==(const Key&) const = default;
    };
    bool IsValid(const Source& source, const Key& now) const;

    std::string m_name;
    std::optional<Key> m_made;
};

}  // namespace raygraph::viewport
