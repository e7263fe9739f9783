// Merges two or more renders of different samples of one picture. Threads: a Merger is used by one thread;
// Merge is a pure function.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "editor/session/render_file.h"

namespace raygraph::session {

// Is a render with the name that errors use for it.
struct NamedRender {
    std::string name;
    RenderFile render;
};

// Adds one render after another, so that no more than two are in memory.
class RAYGRAPH_API Merger {
  public:
    // Error{BadInput} naming two parts when their samples overlap, their settings, scene or environment
    // differ, or one has channels that the other lacks; naming the part when it lacks sums to add, or has
    // planes of another size than its picture. After an error, it is as it was before the call.
    void Add(NamedRender part);
    // The render that has the samples of all parts, with the bits of one run that took all of them, in
    // whatever order they were added. Depth, ids, device and driver are those of the part with the first
    // samples. Error{Usage} without parts. It has none afterwards.
    RenderFile Take();

  private:
    struct Part {
        std::string name;
        SampleRanges samples;
    };
    std::vector<Part> m_parts;
    std::optional<NamedRender> m_merged;  // named as the first part
};

// Merges renders that are in memory.
RAYGRAPH_API RenderFile Merge(std::vector<NamedRender> parts);

}  // namespace raygraph::session
