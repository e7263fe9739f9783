// Tonemap: from linear radiance to what a screen shows.
#pragma once

#include "renderer/graph/renderer.h"
#include "shaders/shared/tonemap_operators.h"

namespace raygraph::passes {

struct TonemapSettings {
    float exposureEv = 0.0f;  // stops: radiance is multiplied with 2^exposureEv
    TonemapOperator tonemapOperator = TonemapOperator::Neutral;

    bool operator==(const TonemapSettings&) const = default;
};

// Reads any float texture and returns rgba8, display-encoded (see shaders/core/tonemap.glsl for each
// operator), alpha passed through. NaN and negative radiance show as black.
[[nodiscard]] TextureId Tonemap(Renderer& renderer, TextureId radiance, const TonemapSettings& settings = {});

}  // namespace raygraph::passes
