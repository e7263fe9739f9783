// The part of the frames of an adaptive render that others do not have: which pixels a frame samples, and
// what decides it. For editor/session/ alone. Threads: that of the Renderer.
#pragma once

#include <array>
#include <map>
#include <optional>

#include "editor/session/adaptive_counts.h"
#include "passes/accumulate.h"
#include "passes/pixel_list.h"

namespace raygraph::session {

class AdaptiveFrames {
  public:
    AdaptiveFrames(Renderer& renderer, Extent2D size, uint32_t firstSample);
    // The same, going on. In an open frame.
    AdaptiveFrames(Renderer& renderer, Extent2D size, uint32_t firstSample, const AdaptiveState& state);

    const AdaptiveCounts& Counts() const { return m_counts; }

    struct Samples {
        passes::ListedPixels pixels;
        uint32_t index = 0;  // of the first, added to those of the pixels
        uint32_t count = 0;  // of each pixel
    };
    // Between frames: decides, where that is due, after waiting for the samples before it. False: each color
    // has the average.
    bool PrepareFor(uint32_t average, const passes::Accumulation& radiance);
    // After it, in an open frame: the samples that it is to render, and to accumulate after this, on the way
    // to that average. Not more than `mostTexels` hold in `mostRows`; at least one of each pixel.
    Samples Take(const passes::Accumulation& radiance, uint32_t average, uint64_t mostTexels,
                 uint32_t mostRows);

    // In an open frame: the counts of samples as passes::Resolve has them.
    TextureId CountsTexture() const;
    // In an open frame; then their state, which waits for it.
    void ReadBack();
    AdaptiveState Take() const;

  private:
    struct NotedReadback {
        Readback variance, mean;
    };
    passes::NotedIds Noted(uint32_t base) const;
    NotedReadback ReadBackNoted(const passes::NotedIds& noted);
    void SetList(const AdaptiveCounts::Next& next);
    void Decide(uint32_t color, const passes::Accumulation& radiance);
    void ForgetBelow(uint32_t base);

    Renderer& m_renderer;
    Extent2D m_size;
    uint32_t m_firstSample;
    AdaptiveCounts m_counts;
    struct ColorList {
        passes::PixelList list;
        uint64_t listed = 0;  // the walk whose pixels it has; 0: of none
    };
    std::array<ColorList, kColors> m_lists;
    std::map<uint32_t, NotedReadback> m_noted;
};

}  // namespace raygraph::session
