// NoiseEstimate is the remaining noise of a picture: requested from a viewport, answered by a later frame,
// without waiting. Threads: that of the viewport.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "base/api.h"
#include "editor/viewport/pending.h"
#include "passes/accumulate.h"
#include "renderer/graph/renderer.h"

namespace raygraph::viewport {

struct NoiseEstimate {
    uint32_t sampleCount = 0;
    // Holds the standard error of a pixel relative to the picture's mean, as the command line reports it for
    // all pixels: sqrt(mean(variance / samples)) / mean. Here both means are over a few thousand pixels. None
    // below two samples, and for a black picture.
    std::optional<double> relativeError;
};

// The first frame declared after a request that shows the path-traced view with a complete sample answers it.
using NoiseRequest = Pending<NoiseEstimate>;

class RAYGRAPH_API NoiseRequests {
  public:
    NoiseRequest Request() { return m_requests.Ask({}); }
    // Answers the pending requests from an accumulation, including what the open frame adds to it.
    void Declare(Renderer& renderer, const passes::AccumulatedIds& samples,
                 const passes::Accumulation::Progress& progress);

  private:
    Questions<NoiseEstimate, std::monostate> m_requests;
};

}  // namespace raygraph::viewport
