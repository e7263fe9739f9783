// RasterView declares the raster picture of a viewport, a mean over jittered samples.
#pragma once

#include <memory>
#include <string>

#include "editor/viewport/view_settings.h"
#include "passes/accumulate.h"
#include "passes/filter_environment.h"
#include "passes/raster.h"

namespace raygraph::viewport {

class RasterView {
  public:
    explicit RasterView(const std::string& name);

    struct Ids {
        TextureId radiance;              // rgba32f, the picture to show, in its full extent
        passes::AccumulatedIds samples;  // undefined before the first one
        TextureId base;                  // shown until the first sample; coarser by baseScale
        uint32_t baseScale = 1;
        // Bound the passes whose time depends on the pixels of `base`: from firstDrawing to before
        // endDrawing.
        PassId firstDrawing, endDrawing;
    };
    // See PathTracedView::Declare. `scale` above 1 draws one coarser picture instead of a sample; else a
    // sample is added until there are maxSamples (0: unlimited).
    Ids Declare(Renderer& renderer, const SceneIds& scene, passes::TraceSettings settings,
                const passes::RasterSettings& raster, uint32_t maxSamples, uint32_t scale);
    void Reset(passes::ResetCause cause) {
        m_samples.Reset(cause);
        m_coarse.Reset(cause);
    }
    // Discards the filtered environment, since the next frame shows another scene. Call it between frames.
    void ReleaseEnvironment(Renderer& renderer);
    void Release(Renderer& renderer);

    const passes::Accumulation& Samples() const { return m_samples; }
    uint32_t TargetSamples() const { return m_targetSamples; }

  private:
    std::string m_name;
    uint32_t m_targetSamples = 0;
    passes::Accumulation m_samples;
    passes::Accumulation m_coarse;  // has one sample
    passes::FilteredEnvironment m_environment;
};

}  // namespace raygraph::viewport
