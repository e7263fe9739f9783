// The remaining noise of a picture: requested from a viewport, answered by a later frame, without waiting.
// Threads: that of the viewport.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/api.h"
#include "passes/accumulate.h"
#include "renderer/graph/renderer.h"

namespace raygraph::viewport {

struct ErrorEstimate {
    uint32_t sampleCount = 0;
    // The standard error of a pixel relative to the picture's mean, as the command line reports it for all
    // pixels: sqrt(mean(variance / samples)) / mean. Here both means are over a few thousand pixels. None
    // below two samples, and for a black picture.
    std::optional<double> relativeError;
};

// A request; copies share its answer. It is ready when the device has finished the first frame that was
// declared after it and shows the path-traced view. Threads: that of the viewport. A request that is
// unanswered when the viewport is destroyed never becomes ready.
class RAYGRAPH_API ErrorRequest {
  public:
    bool IsReady() const;
    ErrorEstimate Result() const;  // Error{Usage} when not ready

  private:
    friend class ErrorRequests;
    struct State;
    std::shared_ptr<State> m_state;
};

class RAYGRAPH_API ErrorRequests {
  public:
    ErrorRequest Request();
    // Answers the pending requests from an accumulation, including what the open frame adds to it.
    void Declare(Renderer& renderer, TextureId mean, TextureId variance, uint32_t sampleCount);

  private:
    std::vector<std::shared_ptr<ErrorRequest::State>> m_requests;
};

}  // namespace raygraph::viewport
