// AdaptiveCounts decides how many samples each pixel of an adaptive render gets, and which are next. It needs
// no device. Threads: plain values, one thread at a time.
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
#pragma once

#include "editor/session/frames/adaptive_state.h"

namespace raygraph::session {

class RAYGRAPH_API AdaptiveCounts {
  public:
    explicit AdaptiveCounts(rhi::Extent2D picture);
    // Continues from a valid state that has wanted counts.
    AdaptiveCounts(rhi::Extent2D picture, AdaptiveState state);

    // Returns everything that determines the next steps; the caller keeps `noted`.
    AdaptiveState State() const;
    uint64_t Total() const { return m_walks[0].total + m_walks[1].total; }  // samples of all pixels
    uint32_t Average() const { return static_cast<uint32_t>(Total() / m_state.counts.size()); }
    uint32_t Least() const;  // smallest count of a pixel

    // Returns the next step towards `average` samples per pixel of each color.
    struct Next {
        enum class Kind {
            Nothing,   // each color has the average
            Decision,  // call Decide for `color`
            Samples    // call Advance
        } kind = Kind::Nothing;
        uint32_t color = 0;  // color of the walk
        // These pixels get equally many samples, none of which has been taken
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
    // At the start of a walk: variance and mean of its pixels with exactly this many samples are to be noted
    // before they get more; 0: of none.
    uint32_t BaseToRecord(uint32_t color) const;

    // Returns the first base that later decisions need.
    uint32_t FirstBaseNeeded() const;

    // Decides how many samples the pixels of a color get in its next stage. `noted` holds the other color's
    // pixels after their first BaseAfter(stage) samples. Throws Error{Usage} if there are no more stages.
    void Decide(uint32_t color, const PixelVariances& noted);

  private:
    // Pixels that miss most samples come first, so that each step is a prefix of the list.
    struct Walk {
        std::vector<WalkPixel> pixels;
        std::vector<uint32_t> leastOfFirst,
            leastOfLast;  // [n]: of the first n pixels, and of the others once those are done
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

}  // namespace raygraph::session
