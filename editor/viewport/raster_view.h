// RasterView: the raster picture of a viewport, a mean over jittered samples.
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
        TextureId base;                  // shown until then, coarser by that factor
        uint32_t baseScale = 1;
        // What takes time by the pixels of the base: the passes from the first on, before the second.
        PassId firstDrawing, endDrawing;
    };
    // As PathTracedView::Declare. `scale` above 1: one coarser picture instead of a sample; else a sample,
    // until there are maxSamples (0: unlimited).
    Ids Declare(Renderer& renderer, const SceneIds& scene, passes::TraceSettings settings,
                const passes::RasterSettings& raster, uint32_t maxSamples, uint32_t scale);
    void Reset(passes::ResetCause cause) {
        m_samples.Reset(cause);
        m_coarse.Reset(cause);
    }
    // The next frame shows another scene: discards the filtered environment. Between frames.
    void ForgetEnvironment(Renderer& renderer);
    void Forget(Renderer& renderer);

    const passes::Accumulation& Samples() const { return m_samples; }
    uint32_t WantedSamples() const { return m_wantedSamples; }

  private:
    std::string m_name;
    uint32_t m_wantedSamples = 0;
    passes::Accumulation m_samples;
    passes::Accumulation m_coarse;  // one sample
    passes::FilteredEnvironment m_environment;
};

}  // namespace raygraph::viewport
