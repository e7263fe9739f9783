// Adaptive renders: AdaptiveFrames chooses the pixels that a frame samples, as AdaptiveCounts decides from
// an AdaptiveState. For editor/session/ alone. Threads: AdaptiveFrames: that of the Renderer; all else:
// plain values and pure functions, one thread at a time for an object.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/api.h"
#include "passes/accumulate.h"
#include "passes/pixel_list.h"
#include "rhi/format.h"

namespace raygraph::session {

// --- AdaptiveState: what is needed to resume an adaptive render ---
// It has the number of samples of each pixel, and the number that it will get.

// Pixels are colored like a chessboard: `color` 0 is white, the first pixel's, and 1 is black.
inline constexpr uint32_t kColors = 2;

inline uint64_t PixelsOfColor(rhi::Extent2D picture, uint32_t color) {
    return (uint64_t{picture.width} * picture.height + (color == 0 ? 1 : 0)) / 2;
}

// Visits the pixels in rows from the top.
template <typename Visit>
void ForPixelsOfColor(rhi::Extent2D picture, uint32_t color, Visit&& visit) {
    for (uint32_t y = 0; y < picture.height; ++y)
        for (uint32_t x = (y + color) % 2; x < picture.width; x += 2) visit(size_t{y} * picture.width + x);
}

// At first all pixels get kFirstBase samples. A stage's number is the average count of a color's pixels at
// its end: 128, 256, 512, ....
inline constexpr uint32_t kFirstBase = 16, kLastStage = 1u << 26;
// The first samples of each pixel, the base, decide a stage: this part of the average. No pixel gets more
// than kMostTimes the average, or barely more.
inline constexpr uint32_t kBasePart = 8, kMostTimes = 16;

// Returns the base by which the stage after this one is decided.
inline uint32_t BaseAfter(uint32_t stage) {
    return stage == kFirstBase ? kFirstBase : stage / (kBasePart / 2);
}

// Sums of R, G and B of each pixel's variance and mean, after its first samples.
struct PixelVariances {
    std::vector<float> variance, mean;
    bool operator==(const PixelVariances&) const = default;
};

// Is stored in a render's file, in rows from the top.
struct RAYGRAPH_API AdaptiveState {
    std::vector<uint32_t> counts;  // samples that each pixel has, at least 1
    std::vector<uint32_t> wanted;  // samples that it gets in this stage; empty: cannot be resumed
    std::array<uint32_t, kColors> stages{kFirstBase, kFirstBase};  // indexed by color
    // Holds, by the base of a later stage, the pixels that already have more samples; 0 for the others.
    std::map<uint32_t, PixelVariances> noted;

    bool operator==(const AdaptiveState&) const = default;
    uint64_t Total() const;
    uint32_t Average() const;  // rounded down
};

// Returns the first base whose samples are still to decide about pixels of the other color.
inline uint32_t FirstBaseToKeep(const AdaptiveState& state, uint32_t color) {
    return BaseAfter(state.stages[1 - color]);
}

// Returns why it is no valid state of such a picture, as in "its pixel 3 has no sample"; empty if it is
// valid.
RAYGRAPH_API std::string FlawOf(const AdaptiveState& state, rhi::Extent2D picture);

// Allocates the samples of an adaptive render: sets the wanted counts of one color's pixels from what was
// noted of the other color's. Each gets at least `least`; the average is `average` or barely more; the rest
// is proportional to the relative deviation of the samples around a pixel. Counts are powers of two if
// `least` and `average` are.
RAYGRAPH_API void AllocateSamples(rhi::Extent2D picture, uint32_t color, const PixelVariances& noted,
                                  std::span<const uint32_t> least, uint32_t average,
                                  std::span<uint32_t> wanted);

// AdaptiveCounts decides how many samples each pixel of an adaptive render gets, and which are next. It
// needs no device.
//
// At first all pixels get 16 samples. Then a render goes through stages whose average is 128, 256, 512, ...
// samples per pixel. The start of each stage decides how many each pixel will have at its end, in proportion
// to the variation of the first samples of the pixels around it, relative to their brightness.
//
// The mean stays exactly unbiased. Pixels are colored like a chessboard. The number of samples of a white
// pixel is a function of the black pixels' first samples alone, and vice versa; so are its color's average,
// its position among its color's pixels, and how far its color has got when a render ends: at the requested
// average, whatever the other color does. First samples are functions of pixel and index, whenever they are
// taken. So the number of a pixel's samples says nothing about their values.
//
// The next step is a function of counts, wanted counts and stages alone, so a render may end after any step,
// and be resumed.
class RAYGRAPH_API AdaptiveCounts {
  public:
    explicit AdaptiveCounts(rhi::Extent2D picture);
    // Continues from a valid state that has wanted counts.
    AdaptiveCounts(rhi::Extent2D picture, AdaptiveState state);

    // Returns everything that determines the next steps; the caller keeps `noted`.
    AdaptiveState State() const;
    uint64_t Total() const { return m_walks[0].total + m_walks[1].total; }  // samples of all pixels
    uint32_t Average() const { return static_cast<uint32_t>(Total() / m_state.counts.size()); }
    uint32_t MinimumCount() const;  // smallest count of a pixel

    // Returns the next step towards `average` samples per pixel of each color.
    struct Next {
        enum class Kind {
            Nothing,   // each color has the average
            Decision,  // call AllocateStage for `color`
            Samples    // call Advance
        } kind = Kind::Nothing;
        uint32_t color = 0;  // color of the walk
        // These pixels get equally many samples, none of which has been taken yet
        uint32_t pixels = 0;  // number of WalkPixels, from the first
        uint32_t taken = 0;   // samples of each since the walk began
        uint32_t length = 0;  // samples of each to take: at least 1, at most what the average needs
    };
    Next NextTo(uint32_t average) const;
    // Records that so many samples were taken, at most next.length.
    void Advance(const Next& next, uint32_t samples);

    // A color's walk has the pixels that get samples together, with their counts when it began. In the first
    // stage, the walk of white pixels contains all pixels.
    struct WalkPixel {
        uint32_t pixel = 0, count = 0;
        uint32_t missing = 0;  // samples until it leaves the walk
    };
    const std::vector<WalkPixel>& WalkPixels(uint32_t color) const { return m_walks[color].pixels; }
    uint64_t WalkId(uint32_t color) const { return m_walks[color].id; }  // differs between walks
    // At the start of a walk: returns the number of samples at which variance and mean of its pixels are to
    // be recorded before they get more; 0 if there is none.
    uint32_t BaseToRecord(uint32_t color) const;

    // Returns the first base that later decisions need.
    uint32_t FirstBaseNeeded() const;

    // Decides how many samples the pixels of a color get in its next stage. `noted` holds the other color's
    // pixels after their first BaseAfter(stage) samples. Throws Error{Usage} if there are no more stages.
    void AllocateStage(uint32_t color, const PixelVariances& noted);

  private:
    // Pixels that miss most samples come first, so that each step is a prefix of the list.
    struct Walk {
        std::vector<WalkPixel> pixels;
        std::vector<uint32_t> leastOfFirst,
            leastOfLast;  // [n]: the least count of the first n pixels, and of the others once those are done
        uint32_t inFlight = 0, taken = 0;
        uint32_t leastOfOthers = 0;  // smallest count of the color's pixels outside of the walk
        uint64_t total = 0;          // samples of the color
        uint64_t id = 0;
    };
    bool IsFirstStage() const { return m_state.stages[0] == kFirstBase; }
    uint64_t Missing(uint32_t color, uint32_t average) const;
    bool CanDecide(uint32_t color) const;
    uint32_t LeastOf(uint32_t color) const;
    uint32_t Target(size_t pixel, uint32_t stage, uint32_t turn) const;
    void FindWalk(uint32_t color);
    void Take(uint32_t color, std::vector<WalkPixel> pixels, uint32_t leastOfOthers);
    void Settle(const Walk& walk, std::vector<uint32_t>& counts) const;

    rhi::Extent2D m_picture;
    AdaptiveState m_state;  // counts are those at the start of each walk
    std::array<Walk, kColors> m_walks;
    uint64_t m_lastId = 0;
};

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
    void AllocateStage(uint32_t color, const passes::Accumulation& radiance);
    void ReleaseBelow(uint32_t base);

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
