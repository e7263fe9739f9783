// The part of the frames of an adaptive render that others do not have: which pixels a frame samples, and
// what decides it. For editor/session/ alone. Threads: that of the Renderer.
#pragma once

#include <map>

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
    // Between frames, before each Take: decides, where that is due, after waiting for the samples before it.
    void DecideIfDue(const passes::Accumulation& radiance);

    struct Samples {
        passes::ListedPixels pixels;
        uint32_t index = 0;  // of the first, added to those of the pixels
        uint32_t count = 0;  // of each pixel
    };
    // In an open frame: the samples that it is to render, and to accumulate after this. As many as make the
    // average `average` or less, and as `mostTexels` hold in `mostRows`; at least one of each pixel.
    Samples Take(const passes::Accumulation& radiance, uint32_t average, uint64_t mostTexels,
                 uint32_t mostRows);

    // In an open frame: the counts of samples as passes::Resolve has them.
    TextureId CountsTexture() const;
    // In an open frame; then their state, which waits for it.
    void ReadBack();
    AdaptiveState Take() const;

  private:
    TextureId Variances(uint32_t base) const;
    void SetList();
    uint32_t FirstBaseToKeep() const;

    Renderer& m_renderer;
    Extent2D m_size;
    uint32_t m_firstSample;
    AdaptiveCounts m_counts;
    passes::PixelList m_list;
    bool m_isListDue = true;
    uint32_t m_taken = 0;  // samples of each pixel of the list
    std::map<uint32_t, Readback> m_variances;
};

}  // namespace raygraph::session
