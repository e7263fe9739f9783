// AdaptiveFrames chooses the pixels that a frame of an adaptive render samples, and what decides this. For
// editor/session/ alone. Threads: that of the Renderer.
#pragma once

#include <array>
#include <map>
#include <optional>

#include "editor/session/frames/adaptive_counts.h"
#include "passes/accumulate.h"
#include "passes/pixel_list.h"

namespace raygraph::session {

class AdaptiveFrames {
  public:
    AdaptiveFrames(Renderer& renderer, Extent2D size, uint32_t firstSample);
    // Continues from a state. Call it in an open frame.
    AdaptiveFrames(Renderer& renderer, Extent2D size, uint32_t firstSample, const AdaptiveState& state);

    const AdaptiveCounts& Counts() const { return m_counts; }

    struct Samples {
        passes::ListedPixels pixels;
        uint32_t index = 0;  // index of the first sample, to be added to those of the pixels
        uint32_t count = 0;  // samples of each pixel
    };
    // Call it between frames: makes a decision if one is due, after waiting for the samples before it.
    // Returns false if each color has the average.
    bool PrepareFor(uint32_t average, const passes::Accumulation& radiance);
    // Call it next, in an open frame: returns the samples that it is to render and to accumulate on the way
    // to the average. They take at most `mostTexels` in `mostRows`, but at least one of each pixel.
    Samples Take(const passes::Accumulation& radiance, uint32_t average, uint64_t mostTexels,
                 uint32_t mostRows);

    // Call it in an open frame: returns the counts of samples for passes::Resolve.
    TextureId CountsTexture() const;
    // Call it in an open frame. Take then returns the state, for which it waits.
    void ReadBack();
    AdaptiveState Take() const;

  private:
    struct VarianceReadback {
        Readback variance, mean;
    };
    passes::VarianceIds Noted(uint32_t base) const;
    VarianceReadback ReadBackVariances(const passes::VarianceIds& noted);
    void SetList(const AdaptiveCounts::Next& next);
    void Decide(uint32_t color, const passes::Accumulation& radiance);
    void ForgetBelow(uint32_t base);

    Renderer& m_renderer;
    Extent2D m_size;
    uint32_t m_firstSample;
    AdaptiveCounts m_counts;
    struct ColorList {
        passes::PixelList list;
        uint64_t listed = 0;  // walk whose pixels it lists; 0: none
    };
    std::array<ColorList, kColors> m_lists;
    std::map<uint32_t, VarianceReadback> m_noted;
};

}  // namespace raygraph::session
