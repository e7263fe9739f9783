// PixelRequests are requests about a pixel, answered by a later frame. Requesting and polling never wait for
// the device. Threads: that of the viewport.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "base/api.h"
#include "editor/viewport/pending.h"
#include "passes/accumulate.h"
#include "passes/trace.h"
#include "renderer/graph/renderer.h"
#include "shaders/shared/light_records.h"
#include "shaders/shared/path_record.h"

namespace raygraph::viewport {

// Describes the surface at the center of a pixel, as in passes::PrimaryHits: the same in every view.
struct PickResult {
    glm::uvec2 pixel{0};
    bool isHit = false;      // the other fields are valid
    uint32_t instance = 0;   // index in the scene
    uint32_t primitive = 0;  // triangle in the file's primitive
    uint32_t material = 0;
    uint32_t geometry = 0;     // index of the mesh's primitive in the scene
    glm::vec3 position{0.0f};  // world space
    glm::vec3 normal{0.0f};    // world space, shading normal
    float depth = 0.0f;        // meters along the camera's forward
};

// Holds the mean of a view in a pixel.
struct PixelValue {
    glm::vec3 radiance{0.0f};  // linear, W/(sr m^2)
    float coverage = 0.0f;     // fraction of the samples that hit a surface
    uint32_t sampleCount = 0;  // samples of this pixel
    // Is the standard error of the mean, per channel; infinite below two samples.
    glm::vec3 standardError{0.0f};
};
struct InspectResult {
    glm::uvec2 pixel{0};
    // Hold values of the views in the answering frame; none for a view without a sample.
    std::optional<PixelValue> pathTraced, raster;
};

// Holds the samples of a path-traced pixel one by one, as its mean has them.
struct PixelSamples {
    glm::uvec2 pixel{0};
    uint32_t firstSample = 0;       // index of the first value
    std::vector<glm::vec3> values;  // linear radiance
};

// Holds the path of one sample. session::PathIn and session::LinesOf explain it in words.
struct PathResult {
    glm::uvec2 pixel{0};
    uint32_t sample = 0;  // index
    std::vector<gpu::PathVertexRecord>
        vertices;                  // in the order of the path (shaders/shared/path_vertex_list.h)
    glm::dvec3 origin{0.0};        // in world space: positions of the vertices are relative to it
    gpu::LightSetRecord lights{};  // how the vertices number lights
};

// The first frame that is declared after a request answers it; with PreparingView::Preview, the first one
// with the pipelines for it.
using Pick = Pending<PickResult>;
using Inspection = Pending<InspectResult>;
using SamplesRequest = Pending<PixelSamples>;
using PathRequest = Pending<PathResult>;

// Holds the pending requests of a viewport. A pixel outside a later, smaller size is answered without a hit
// or a value.
class RAYGRAPH_API PixelRequests {
  public:
    Pick RequestPick(glm::uvec2 pixel) { return m_picks.Ask(pixel); }
    Inspection RequestInspection(glm::uvec2 pixel) { return m_inspections.Ask(pixel); }
    SamplesRequest RequestSamples(glm::uvec2 pixel, uint32_t first, uint32_t count) {
        return m_samples.Ask({pixel, first, count});
    }
    PathRequest RequestPath(glm::uvec2 pixel, uint32_t sample) { return m_paths.Ask({pixel, sample, 1}); }

    // Declares the passes that answer the pending requests. `settings` is the picture's.
    void DeclarePicks(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings);
    // Describes the accumulation of a shown view, with what the open frame adds to it.
    struct Shown {
        passes::AccumulatedIds samples;
        passes::Accumulation::Progress progress;
    };
    void DeclareInspections(Renderer& renderer, Extent2D extent, const std::optional<Shown>& pathTraced,
                            const std::optional<Shown>& raster);
    // Declares the traces of the requested samples and paths. mayWait: this frame answers all, however long
    // pipelines take.
    void DeclareSamples(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                        bool mayWait);

  private:
    struct SampleRange {
        glm::uvec2 pixel{0};
        uint32_t first = 0, count = 1;
    };
    Questions<PickResult, glm::uvec2> m_picks;
    Questions<InspectResult, glm::uvec2> m_inspections;
    Questions<PixelSamples, SampleRange> m_samples;
    Questions<PathResult, SampleRange> m_paths;
};

}  // namespace raygraph::viewport
