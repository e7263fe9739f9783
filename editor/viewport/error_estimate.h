// How noisy a picture still is: asked of a viewport, answered by a later frame, without waiting.
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
    // The standard error of a pixel as a part of the picture's mean, as the command line reports it for all
    // pixels: sqrt(mean(variance / samples)) / mean. Here both means are over a few thousand pixels. None
    // below two samples, and for black.
    std::optional<double> relativeError;
};

// A request; copies are of the same one. It is ready once the device has done the first frame that was
// declared after it and shows the path-traced view. Threads: that of the viewport. What the viewport has not
// answered when it is destroyed is never ready.
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
    // Answers the requests at hand from an accumulation, with what the open frame adds to it.
    void Declare(Renderer& renderer, TextureId mean, TextureId variance, uint32_t sampleCount);

  private:
    std::vector<std::shared_ptr<ErrorRequest::State>> m_requests;
};

}  // namespace raygraph::viewport
