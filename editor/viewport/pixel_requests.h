// Requests about a pixel, answered by a later frame. Requesting and polling never wait for the device.
// Threads: that of the viewport.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "base/api.h"
#include "passes/accumulate.h"
#include "passes/trace.h"
#include "renderer/graph/renderer.h"

namespace raygraph::viewport {

// The surface at the center of a pixel, as in passes::PrimaryHits: the same in every view.
struct PickResult {
    glm::uvec2 pixel{0};
    bool isHit = false;      // the other fields are valid
    uint32_t instance = 0;   // of the scene
    uint32_t primitive = 0;  // triangle of the file's primitive
    uint32_t material = 0;
    uint32_t geometry = 0;     // primitive of a mesh, numbered over the scene
    glm::vec3 position{0.0f};  // world space
    glm::vec3 normal{0.0f};    // world space, shading normal
    float depth = 0.0f;        // meters along the camera's forward
};

// The mean of a view in a pixel.
struct PixelValue {
    glm::vec3 radiance{0.0f};  // linear, W/(sr m^2)
    float coverage = 0.0f;     // share of the samples that hit a surface
    uint32_t sampleCount = 0;  // of this pixel
    // Of the mean, per channel; infinite below two samples.
    glm::vec3 standardError{0.0f};
};
struct InspectResult {
    glm::uvec2 pixel{0};
    // Of the views that the answering frame showed. None for a view without a sample.
    std::optional<PixelValue> pathTraced, raster;
};

// A request; copies share its answer. Threads: that of the viewport. It is ready when the device has finished
// the first frame that was declared after it; if that frame is dropped, the next one answers. A request that
// is unanswered when the viewport is destroyed never becomes ready.
class RAYGRAPH_API Pick {
  public:
    bool IsReady() const;
    PickResult Result() const;  // Error{Usage} when not ready

  private:
    friend class PixelRequests;
    struct State;
    std::shared_ptr<State> m_state;
};

class RAYGRAPH_API Inspection {
  public:
    bool IsReady() const;
    InspectResult Result() const;  // Error{Usage} when not ready

  private:
    friend class PixelRequests;
    struct State;
    std::shared_ptr<State> m_state;
};

// The pending requests of a viewport. A pixel outside a later, smaller size is answered without a hit or a
// value.
class RAYGRAPH_API PixelRequests {
  public:
    Pick RequestPick(glm::uvec2 pixel);
    Inspection RequestInspection(glm::uvec2 pixel);

    // Declare the passes that answer the pending requests. `settings` is of the picture.
    void DeclarePicks(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings);
    // A shown view: its accumulation, including what the open frame adds to it.
    struct Shown {
        TextureId mean, variance;
        passes::Accumulation::Progress progress;
    };
    void DeclareInspections(Renderer& renderer, Extent2D extent, const std::optional<Shown>& pathTraced,
                            const std::optional<Shown>& raster);

  private:
    std::vector<std::shared_ptr<Pick::State>> m_picks;
    std::vector<std::shared_ptr<Inspection::State>> m_inspections;
};

}  // namespace raygraph::viewport
