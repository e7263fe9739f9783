// RealTimeErrors are the errors of the real-time picture against the path-traced one: requested from a
// viewport that compares both, answered by a later frame, without waiting. Threads: that of the viewport.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "base/api.h"
#include "editor/viewport/pending.h"
#include "passes/accumulate.h"
#include "renderer/graph/renderer.h"

namespace raygraph::viewport {

// The reference is the path-traced mean of the same frame, so its own noise is a part of the differences.
struct RealTimeErrors {
    uint32_t referenceSamples = 0;
    double relativeSquaredError = 0.0;  // mean of passes::RelativeSquaredError
    // The part of it that the reference's noise is expected to be; none below two samples.
    std::optional<double> referenceNoise;
    double flip = 0.0;  // mean of passes::Flip
    // Mean of passes::Flicker over the measured frames of about the last second; none in the first one after
    // a change.
    std::optional<double> flicker;
};

using RealTimeErrorsRequest = Pending<RealTimeErrors>;

class RAYGRAPH_API RealTimeErrorRequests {
  public:
    explicit RealTimeErrorRequests(std::string name) : m_name(std::move(name)) {}

    RealTimeErrorsRequest Request() { return m_requests.Ask({}); }
    // Describes what the open frame compares.
    struct Shown {
        TextureId picture, display;  // of the real-time view: rgba32f, rgba8
        passes::AccumulatedIds samples;
        passes::Accumulation::Progress progress;
        TextureId referenceDisplay;
        float pixelsPerDegree = 0.0f;
        double seconds = 0.0;  // time of the frame
    };
    // Says that something has changed since the last frame.
    void NoteChange() { m_momentFrames = 0; }
    // Answers the pending requests, once every pixel of the reference has a sample.
    void Declare(Renderer& renderer, const Shown& shown);
    void Release(Renderer& renderer) { renderer.Release(MomentsName()); }

  private:
    std::string MomentsName() const { return m_name + ".moments"; }

    Questions<RealTimeErrors, std::monostate> m_requests;
    std::string m_name;
    uint32_t m_momentFrames = 0;   // frames in the moments
    double m_momentSeconds = 0.0;  // time of the last of them
};

}  // namespace raygraph::viewport
