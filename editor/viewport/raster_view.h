// RasterView: the raster picture of a viewport, a mean over jittered samples.
#pragma once

#include <memory>
#include <string>

#include "editor/viewport/view_settings.h"
#include "passes/accumulate.h"
#include "passes/filter_environment.h"
#include "passes/raster.h"

namespace raygraph::viewport {

// What is nearest in each pixel: drawn, or found by rays on a device that cannot draw it.
passes::RasterVisibility DeclareVisibility(Renderer& renderer, const SceneIds& scene,
                                           const passes::TraceSettings& settings, passes::FilmPosition film);

class RasterView {
  public:
    explicit RasterView(const std::string& name);

    // As PathTracedView::Declare; the mean and its variance, rgba32f. Without maxSamples (0) there is no end.
    passes::AccumulatedIds Declare(Renderer& renderer, const SceneIds& scene, passes::TraceSettings settings,
                                   uint32_t maxSamples);
    void Reset(passes::ResetCause cause) { m_samples.Reset(cause); }
    // The next frame shows another scene: what is kept of its environment is no longer true. Between frames.
    void ForgetEnvironment(Renderer& renderer);
    void Forget(Renderer& renderer);

    const passes::Accumulation& Samples() const { return m_samples; }

  private:
    std::string m_name;
    passes::Accumulation m_samples;
    passes::FilteredEnvironment m_environment;
};

}  // namespace raygraph::viewport
