// Capture is a whole picture as numbers: requested from a viewport, answered by a later frame, without
// waiting. Threads: that of the viewport.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "base/api.h"
#include "editor/viewport/pending.h"
#include "editor/viewport/view_settings.h"
#include "passes/accumulate.h"
#include "passes/raster.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"
#include "renderer/scene/model/camera_view.h"

namespace raygraph::viewport {

// Rows are from the top. Texels have four floats: RGBA, linear.
struct CaptureResult {
    Extent2D extent;
    bool isRaster = false;     // false: path-traced
    uint32_t sampleCount = 0;  // per pixel
    // The fields below are those of the captured frame
    scene::CameraView camera;
    LensSettings lens;
    PathSettings paths;
    passes::RasterSettings raster;
    EnvironmentSettings environment;  // GpuScene::ShownEnvironment
    passes::ExactSums sums;   // sums of the samples, with squares; another renderer can continue from them
    std::vector<float> mean;  // w: coverage
    std::vector<float> variance;  // variance of one sample; w is undefined
    std::vector<float> denoised;  // ShowSettings::isDenoised: the mean, denoised; else empty
    // The surface at the center of each pixel (passes::PrimaryHits).
    std::vector<float> albedo;       // w is undefined
    std::vector<float> normal;       // world space; w is undefined
    std::vector<float> depth;        // per pixel, in meters along the camera's forward; infinite: nothing
    std::vector<uint32_t> instance;  // per pixel; 0xFFFFFFFF: nothing
    std::vector<uint32_t> material;
};

// The first frame that shows light and ends with a whole sample answers a request.
using Capture = Pending<CaptureResult>;

class RAYGRAPH_API CaptureRequests {
  public:
    Capture Request() { return m_captures.Ask({}); }
    bool HasUnanswered() { return m_captures.HasUnanswered(); }
    // Describes what the open frame shows, with what it adds.
    struct Shown {
        passes::AccumulatedIds samples;
        passes::Accumulation::Progress progress;
        std::optional<TextureId> denoised;
        bool isRaster = false;
        scene::CameraView camera;
        LensSettings lens;
        PathSettings paths;
        passes::RasterSettings raster;
        EnvironmentSettings environment;
    };
    // Answers the pending requests if the number of samples is whole.
    void Declare(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                 const Shown& shown);

  private:
    Questions<CaptureResult, std::monostate> m_captures;
};

}  // namespace raygraph::viewport
