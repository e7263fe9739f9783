// How many samples each pixel of an adaptive render gets, and which are next: values of the host alone,
// without a device. Threads: plain values, one thread at a time.
//
// A render goes through stages whose average is 64, 128, 256, ... samples a pixel. In each, all pixels
// first get a base, a quarter of the average; then it is decided how many each is to have at the stage's
// end, in proportion to how much the base samples around it vary: that makes the error of the picture, as
// ImageStatistics measures it, the smallest for its samples.
//
// The mean stays exactly unbiased. The pixels are those of a chessboard: what a white one gets is a function
// of the black ones' base samples alone, and the other way round; so is the number that makes the averages
// right, which each color has for itself. Base samples are functions of pixel and index, whenever they were
// taken. So the number of a pixel's samples says nothing about their values.
//
// What comes next is a function of counts, wanted counts and stage alone: a render may end after any step,
// and be gone on with.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/api.h"
#include "rhi/format.h"

namespace raygraph::session {

// Of a render's file. Rows from the top.
struct RAYGRAPH_API AdaptiveState {
    std::vector<uint32_t> counts;  // samples that a pixel has, at least 1
    std::vector<uint32_t> wanted;  // those that it gets in this stage, or of its base; empty: it cannot go on
    uint32_t stage = 64;           // average number of samples at its end
    bool isDecided = false;        // beyond the base
    // Of later bases of that many samples: the variance of one of them (R + G + B), of the pixels that have
    // more already; 0 of the others.
    std::map<uint32_t, std::vector<float>> variances;

    bool operator==(const AdaptiveState&) const = default;
    uint64_t Total() const;
    uint32_t Average() const;  // rounded down
};

inline constexpr uint32_t kFirstStage = 64;
// The base is this part of the average, and no pixel is wanted to have more than that many times the average.
inline constexpr uint32_t kBasePart = 4, kMostTimes = 16;

// Why it cannot be a state of so many pixels, as in "its pixel 3 has no sample"; empty: it can.
RAYGRAPH_API std::string FlawOf(const AdaptiveState& state, uint64_t pixelCount);

class RAYGRAPH_API AdaptiveCounts {
  public:
    explicit AdaptiveCounts(rhi::Extent2D picture);
    // Goes on; of a state without flaw, with wanted counts.
    AdaptiveCounts(rhi::Extent2D picture, AdaptiveState state);

    // All that makes the next steps; `variances` are kept by the caller.
    const AdaptiveState& State() const { return m_state; }
    uint64_t Total() const { return m_total; }  // samples of all pixels
    uint32_t Average() const { return static_cast<uint32_t>(m_total / m_state.counts.size()); }
    uint32_t Least() const { return m_least; }  // of a pixel
    uint32_t Base() const { return m_state.stage / kBasePart; }

    // Whether Decide must be called, with the variance of one of the first Base() samples of each pixel,
    // before there is a next step.
    bool NeedsDecision() const { return m_members.empty(); }
    void Decide(std::span<const float> variance);

    // The pixels that the next step samples, by their number, in order; as long as none of them is done, and
    // no pixel's number of samples becomes that of a later base.
    const std::vector<uint32_t>& Members() const { return m_members; }
    // Samples of each member until then.
    uint32_t StepLength() const { return m_stepLength; }
    // Takes so many of them, at most StepLength. True: the members are others now.
    bool Advance(uint32_t samples);
    // The bases beyond the last that was decided by, of which members have exactly as many samples: their
    // variance is to be noted before they get more.
    std::vector<uint32_t> BasesToNote() const;

  private:
    uint32_t Target(size_t pixel, uint32_t turn) const;
    void FindMembers();

    rhi::Extent2D m_picture;
    AdaptiveState m_state;
    uint64_t m_total = 0;
    uint32_t m_least = 0;
    std::vector<uint32_t> m_members;
    uint32_t m_stepLength = 0;
};

// How many samples each pixel is to have: at least `least` of it, on average over each color of the
// chessboard `average` or barely more, and beyond that in proportion to the standard deviation around it.
// Multiples of `unit`; from 16 of them on, of an eighth to a sixteenth of themselves.
RAYGRAPH_API std::vector<uint32_t> AllocateSamples(rhi::Extent2D picture, std::span<const float> variance,
                                                   std::span<const uint32_t> least, uint32_t average,
                                                   uint32_t unit);

}  // namespace raygraph::session
