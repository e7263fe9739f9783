// Tonemap: converts linear radiance to display values. Threads: that of the Renderer.
#pragma once

#include <functional>
#include <glm/glm.hpp>

#include "base/api.h"
#include "passes/tiles.h"
#include "renderer/graph/renderer.h"
#include "shaders/shared/tonemap_operators.h"

namespace raygraph::passes {

struct TonemapSettings {
    float exposureEv = 0.0f;  // stops: radiance is multiplied with 2^exposureEv
    TonemapOperator tonemapOperator = TonemapOperator::Neutral;
    bool isOpaque = false;  // alpha is 1, not the radiance's
    // The color shown is that of what alpha covers: radiance, which is 0 for the rest of the pixel, is
    // divided by it. For formats whose alpha is not associated, as PNG.
    bool isUnassociated = false;
    glm::mat3 whiteBalance{1.0f};  // on the radiance: passes/white_balance.h

    bool operator==(const TonemapSettings&) const = default;
};

// Reads any float texture and returns rgba8, display-encoded (see shaders/core/tonemap.glsl for each
// operator), alpha passed through or 1. NaN and negative radiance show as black.
[[nodiscard]] RAYGRAPH_API TextureId Tonemap(Renderer& renderer, TextureId radiance,
                                             const TonemapSettings& settings = {});

// Writes into a region of `display`, rgba8; the rest of it stays. `radiance` may be of another extent: then
// it is scaled to that of the display, each pixel from the texel that it lies in. `onSubmitted` runs when the
// pass has been submitted, and never if it is culled or its frame dropped; it must not throw. Error{Usage}
// for another format, and a region outside of the display.
[[nodiscard]] RAYGRAPH_API TextureId TonemapInto(Renderer& renderer, TextureId radiance, TextureId display,
                                                 const Region& region, const TonemapSettings& settings = {},
                                                 std::function<void()> onSubmitted = {});

}  // namespace raygraph::passes
