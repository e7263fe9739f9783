// Merges two or more renders of different samples of one picture. Threads: a Merger is used by one thread;
// Merge is a pure function.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "editor/session/file/render_file.h"

namespace raygraph::session {

// Holds a render with the name that errors use for it.
struct NamedRender {
    std::string name;
    RenderFile render;
};

// Adds one render after another, so that no more than two are in memory.
class RAYGRAPH_API Merger {
  public:
    // Throws Error{BadInput} that names two parts if their samples overlap, if their settings, scene or
    // environment differ, or if one has channels that the other lacks; or that names the part if it lacks
    // sums, or has planes of another size than its picture. After an error, the Merger is as it was before
    // the call.
    void Add(NamedRender part);
    // Returns the render with the samples of all parts. It has the bits of one run that took all of them, in
    // whatever order they were added, but for DenoisingPlanes: they have its values to rounding, and the
    // first halves of all parts make their first half. Depth, ids, device and driver are those of the part
    // with the first samples. Throws Error{Usage} without parts. The Merger is empty afterwards.
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
