// Explain: why a pixel of a path-traced picture has its color. Samples are functions of seed, pixel and index
// alone, so that any of them can be traced again on the device that made it, with a record of each vertex
// (shaders/shared/path_vertex_list.h).
//
//   session::Explainer explainer(*device, session::LoadInput("scene.gltf"), settings);
//   const session::Explanation why = explainer.Explain({.pixel = {320, 180}, .brightest = 3});
//   std::puts(session::Describe(why).c_str());
//
// Threads: one at a time, as a Renderer.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/api.h"
#include "editor/session/explain/path_names.h"
#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/scene_input.h"
#include "editor/session/settings/tracing_choice.h"
#include "rhi/device.h"
#include "shaders/shared/path_record.h"

namespace raygraph::session {

struct ExplainRequest {
    glm::uvec2 pixel{0};             // of the whole picture, from its upper left corner
    std::optional<uint32_t> sample;  // explains this one alone
    // Without `sample`: explains so many of the samples from firstSample on, those of the largest luminance.
    uint32_t brightest = 1;
    uint32_t firstSample = 0;
    uint32_t sampleCount = 64;
    // Traces on the host, by the shader text compiled as C++ (editor/session/cpu/trace.h): the numbers are
    // those of the device, to rounding.
    bool isOnCpu = false;
};

// Holds the path of one sample.
struct ExplainedPath {
    uint32_t sample = 0;                          // index
    glm::vec3 value{0.0f};                        // radiance, as in the picture
    double varianceShare = 0.0;                   // of the pixel's variance; 0 if one sample was requested
    std::vector<gpu::PathVertexRecord> vertices;  // in the order of the path
    // The contributions of the vertices sum to `value`, to the bit. False is possible where a device rounds
    // differently in programs that differ; then the record is of nearly the same path.
    bool isExact = false;
};

struct Explanation {
    glm::uvec2 pixel{0};
    uint32_t firstSample = 0;
    std::vector<glm::vec3> values;     // of all samples that were looked at
    std::vector<uint32_t> discarded;   // those that were infinite or NaN, which a picture has as black
    glm::dvec3 mean{0.0};              // of these
    double relativeError = 0.0;        // standard error of the mean of luminance, over that mean
    std::vector<ExplainedPath> paths;  // by luminance, the brightest first
    glm::dvec3 origin{0.0};            // in world space: positions of the records are relative to it
    PathNames names;
};

class RAYGRAPH_API Explainer {
  public:
    // Uploads the scene. `device` outlives the object. Throws as the constructor of Session does, and
    // SettingError of kind Usage for a view that is not path-traced.
    Explainer(rhi::Device& device, SceneInput input, const PictureSettings& settings,
              const TracingChoice& tracing = {});
    ~Explainer();
    Explainer(const Explainer&) = delete;
    Explainer& operator=(const Explainer&) = delete;

    // Traces the samples and the records, and waits for them. Throws Error{Usage} for a pixel outside of the
    // picture, for no sample, and for sample indices beyond the last.
    Explanation Explain(const ExplainRequest& request);

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

// --- Explanations of what a host has traced itself, such as a viewport's requests ---

// Returns the samples of a pixel from firstSample on, with their mean and noise; without paths and names.
RAYGRAPH_API Explanation ExplainSamples(glm::uvec2 pixel, uint32_t firstSample,
                                        std::vector<glm::vec3> values);
// Returns the indices of so many samples, or of all: discarded ones first, then by luminance, the brightest
// first.
RAYGRAPH_API std::vector<uint32_t> BrightestOf(const Explanation& explanation, size_t count);
// Returns the path of a sample, which is one of `explanation`, from its record.
RAYGRAPH_API ExplainedPath PathIn(const Explanation& explanation, uint32_t sample,
                                  std::vector<gpu::PathVertexRecord> vertices);

// Explains one pixel.
RAYGRAPH_API Explanation Explain(rhi::Device& device, SceneInput input, const PictureSettings& settings,
                                 const ExplainRequest& request);

// Returns the first vertex with which the sum of the contributions is infinite or NaN: a picture has such a
// sample as black. None: the sum is finite.
RAYGRAPH_API std::optional<size_t> NonFiniteVertex(std::span<const gpu::PathVertexRecord> path);

// Returns the luminance of a radiance, linear Rec. 709.
RAYGRAPH_API double LuminanceOf(const glm::vec3& radiance);

}  // namespace raygraph::session
