// How many samples each pixel of an adaptive render gets, and which are next: values of the host alone,
// without a device. Threads: plain values, one thread at a time.
//
// At first all pixels get 16 samples. Then a render goes through stages whose average is 128, 256, 512, ...
// samples a pixel. At the start of each it is decided how many each pixel is to have at its end, in
// proportion to how much the first samples of the pixels around it vary, relative to how bright these are.
//
// The mean stays exactly unbiased. The pixels are those of a chessboard. How many samples a white one gets is
// a function of the black ones' first samples alone, and the other way round; so are its color's average, its
// turn among its color's pixels, and how far its color has got when a render ends: at the average that was
// asked for, whatever the other color does. First samples are functions of pixel and index, whenever they
// were taken. So the number of a pixel's samples says nothing about their values.
//
// What comes next is a function of counts, wanted counts and stages alone: a render may end after any step,
// and be gone on with.
#pragma once

#include "editor/session/adaptive_state.h"

namespace raygraph::session {

class RAYGRAPH_API AdaptiveCounts {
  public:
    explicit AdaptiveCounts(rhi::Extent2D picture);
    // Goes on; of a state without flaw, with wanted counts.
    AdaptiveCounts(rhi::Extent2D picture, AdaptiveState state);

    // All that makes the next steps; `noted` is kept by the caller.
    AdaptiveState State() const;
    uint64_t Total() const { return m_walks[0].total + m_walks[1].total; }  // samples of all pixels
    uint32_t Average() const { return static_cast<uint32_t>(Total() / m_state.counts.size()); }
    uint32_t Least() const;  // of a pixel

    // What comes next on the way to an average of `average` samples of each color.
    struct Next {
        enum class Kind {
            Nothing,   // each color has it
            Decision,  // Decide must be called, for that color
            Samples    // then Advance
        } kind = Kind::Nothing;
        uint32_t color = 0;  // whose walk it is
        // Samples of some of its pixels: each gets as many, and none is done before
        uint32_t pixels = 0;  // the first of WalkPixels
        uint32_t taken = 0;   // that each of them has got since the walk began
        uint32_t length = 0;  // samples of each; no more than the average needs, and at least 1
    };
    Next NextTo(uint32_t average) const;
    // Takes so many of its samples, at most its length.
    void Advance(const Next& next, uint32_t samples);

    // A color's walk: pixels that get samples together, and how many each had when it began. In the first
    // stage the walk of the white ones is that of all.
    struct WalkPixel {
        uint32_t pixel = 0, count = 0;
        uint32_t missing = 0;  // until it leaves the walk
    };
    const std::vector<WalkPixel>& WalkPixels(uint32_t color) const { return m_walks[color].pixels; }
    uint64_t WalkId(uint32_t color) const { return m_walks[color].id; }  // another one of another walk
    // At the start of a walk: of its pixels that have exactly so many samples, variance and mean are to be
    // noted before they get more; 0: of none.
    uint32_t BaseToNote(uint32_t color) const;

    // The first base that is still to decide.
    uint32_t FirstBaseNeeded() const;

    // How many samples pixels of that color get in its next stage. `noted`: of the first BaseAfter(stage)
    // samples of the other color's pixels. Error{Usage} if there are no more stages.
    void Decide(uint32_t color, const NotedSamples& noted);

  private:
    // Those that miss most come first, so that the pixels of each step are the first ones.
    struct Walk {
        std::vector<WalkPixel> pixels;
        std::vector<uint32_t> leastOfFirst,
            leastOfLast;  // [n]: of the first n, and of those behind when done
        uint32_t onTheirWay = 0, taken = 0;
        uint32_t leastOfOthers = 0;  // of the color's pixels that are not of the walk
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
    AdaptiveState m_state;  // counts as of the start of each walk
    std::array<Walk, kColors> m_walks;
    uint64_t m_lastId = 0;
};

}  // namespace raygraph::session
