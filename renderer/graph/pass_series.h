// PassSeries: passes that are executed over several frames, because together they take longer than a frame
// may.
//
//   renderer.BeginSeries(series, 15.0);                    // milliseconds of this frame
//   const TextureId blurred = Blur(renderer, source);      // declared alike in each of the frames
//   if (renderer.EndSeries()) renderer.Present(blurred);   // this frame executes the last of them
//
// Each frame declares the same passes between BeginSeries and EndSeries, and executes those that fit into its
// milliseconds, at least one of them or a part of it. Compute passes, and those that PassBuilder::Dividable
// marks, may be divided. Transient textures and buffers that are created in the series keep their contents
// between frames until their last use. Only a frame in which EndSeries returns true may use the results, and
// inputs must stay unchanged until then. A pass that writes no resource of the series is no part of it, and
// is executed in every frame that declares it.
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
    // Learns the GPU times of passes from a frame. A pass without a time counts as long as the longest known
    // one of its name, or else of any name. If no time is known at all, it gets a frame of its own.
    void AddTimings(const FrameTiming& timing);

  private:
    friend class Renderer;
    friend class SeriesFrame;

    // Says that all passes before `pass` are done, and `part` of the kParts parts of `pass`.
    struct Place {
        uint32_t pass = 0;
        uint32_t part = 0;
        bool operator==(const Place&) const = default;
    };
    struct Known {
        std::string name;
        double ms = 0.0;  // for all parts; 0: unknown
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
