// PassSeries: passes that are executed over several frames, because together they take longer than a frame
// may.
//
//   renderer.BeginSeries(series, 15.0);                    // milliseconds of this frame
//   const TextureId blurred = Blur(renderer, source);      // declared alike in each of the frames
//   if (renderer.EndSeries()) renderer.Present(blurred);   // this frame executes the last of them
//
// Each frame executes the passes, or parts of those that can be divided, that fit
// (PassBuilder::Dividable). A pass that fits in no frame and cannot be divided is executed alone.
// Transients that are created in between are kept from frame to frame, until no pass of the series needs
// them any more; in the last frame, all that is still there is the result of the last passes. Passes that
// write nothing of this are no part of the series: they are executed in the frame that declares them.
// Inputs must not change until the series is complete.
//
// Threads: that of the Renderer.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "renderer/graph/ids.h"

namespace raygraph {

struct FrameTiming;

// Holds how far a series has come, and how long its passes take. It must outlive the frames that declare it.
class RAYGRAPH_API PassSeries {
  public:
    // Dispatches are divided into this many parts at most.
    static constexpr uint32_t kParts = 64;

    // `name` distinguishes the series of a Renderer.
    explicit PassSeries(std::string_view name) : m_name(name) {}

    // Returns whether frames have executed some of its passes, but not yet all.
    bool IsBegun() const { return m_done != Place{}; }
    // Learns from the GPU times of a frame how long passes take. A pass without times counts as long as the
    // longest one of its name, or of any name; if there are no times at all, as too long.
    void AddTimings(const FrameTiming& timing);

  private:
    friend class Renderer;
    friend class SeriesFrame;

    // Everything before `pass` is done, and so many parts of it.
    struct Place {
        uint32_t pass = 0;
        uint32_t part = 0;
        bool operator==(const Place&) const = default;
    };
    struct Known {
        std::string name;
        double ms = 0.0;  // of all parts; 0: unknown
    };
    struct Kept {
        std::string name;
        uint32_t lastPass = 0;  // the last one of the series that uses it
    };
    struct Executed {
        uint64_t frame = 0;
        PassId id;
        uint32_t pass = 0;
        uint32_t parts = 0;
    };

    std::string m_name;
    Place m_done;
    std::vector<Known> m_passes;
    std::vector<std::string> m_kept;  // names of the resources that are kept
    std::deque<Executed> m_executed;  // in the latest frames
};

}  // namespace raygraph
